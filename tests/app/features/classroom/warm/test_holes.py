"""What a copy of a warm process allocates lies together, so that few pages are copied."""

from __future__ import annotations

import subprocess
import sys

import pytest

SCATTERED = """
from app.features.classroom.warm.holes import fill_holes

PAGE, SIZE = 4096, 200
many = [bytes(SIZE) for _ in range(100_000)]
del many[::40]  # what stays holds its pages
held = fill_holes() if {filled} else []
own = [bytes(SIZE) for _ in range(2000)]
print(len({{id(each) // PAGE for each in own}}))
"""
TOGETHER = 2000 * 240 // 4096


HEAP = """
import ctypes
from app.features.classroom.warm.holes import fill_holes

libc = ctypes.CDLL(None)
libc.malloc.restype = ctypes.c_void_p
PAGE, SIZE = 4096, ctypes.c_size_t(3000)
many = [libc.malloc(SIZE) for _ in range(8000)]
for each in many[::2]:
    libc.free(ctypes.c_void_p(each))
held = fill_holes() if {filled} else []
old = {{each // PAGE for each in many}}
own = [libc.malloc(SIZE) for _ in range(500)]
print(sum(each // PAGE in old for each in own))
"""

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="copies are made on Linux alone")


def printed(code: str, *, filled: bool) -> int:
    """What a process of its own prints."""
    done = subprocess.run(
        [sys.executable, "-c", code.format(filled=filled)],
        check=True, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert not done.stderr, "the allocator's table is for nobody to see"
    return int(done.stdout)


def test_new_objects_lie_together_where_gaps_are_filled():
    assert printed(SCATTERED, filled=False) > 5 * TOGETHER
    assert printed(SCATTERED, filled=True) < 2 * TOGETHER


def test_new_arrays_lie_beyond_those_of_before():
    assert printed(HEAP, filled=False) > 400
    assert printed(HEAP, filled=True) < 10
