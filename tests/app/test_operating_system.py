"""What systems do differently: where threads take their memory."""

from __future__ import annotations

import subprocess
import sys

import pytest

THREADS = """
import ctypes, sys, threading
from app.operating_system import share_freed_memory
if sys.argv[2] == "shared":
    share_freed_memory()
done = threading.Barrier(5)
def work():
    kept = [bytearray(5000) for _ in range(100)]
    done.wait(30)
    return kept
for _ in range(4):
    threading.Thread(target=work).start()
done.wait(30)
libc = ctypes.CDLL(None)
libc.fopen.restype = ctypes.c_void_p
file = ctypes.c_void_p(libc.fopen(sys.argv[1].encode(), b"w"))
libc.malloc_info(0, file)
libc.fclose(file)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="glibc alone has arenas")
def test_threads_share_one_arena(tmp_path):
    arenas = {}
    for how in ("shared", "apart"):
        file = tmp_path / how
        subprocess.run([sys.executable, "-c", THREADS, str(file), how], check=True, timeout=60)
        arenas[how] = file.read_text().count("<heap nr=")
    assert arenas["shared"] == 1 < arenas["apart"]
