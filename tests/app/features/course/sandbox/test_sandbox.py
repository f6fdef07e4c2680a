# ruff: noqa: E501 - pieces of code are not broken
"""Hostile code is stopped with the reason, nothing else is harmed, and the next file is graded."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys

import numpy as np
import pytest
from course.solutions import ARRAYS

from app.features.course.grading import grade
from app.features.course.lesson import lesson_of
from app.features.course.sandbox import wire
from app.features.course.sandbox.student_process import StudentError, StudentProcess, _served
from app.settings.config import ROOT

ARRAY = np.arange(3.0)
linux = pytest.mark.skipif(sys.platform != "linux", reason="fences of Linux's kernel")


def answer(body: str, seed: int | None = None):
    source = "def f(a):\n" + "".join(f"    {line}\n" for line in body.splitlines())
    with StudentProcess("mine.py", source) as process:
        return process.call("f", (ARRAY,), seed)


HOSTILE = {
    "endless loop": ("while True: pass", "does not end within 3 s"),
    "fork": ("import os\nos.fork()", "starts another program"),
    "fork bomb": ("import os\nwhile True:\n    try: os.fork()\n    except OSError: pass", "does not end"),
    "much memory": ("bytearray(10**10)", "MemoryError"),
    "another program": ("import subprocess\nsubprocess.run(['true'])", "starts another program"),
    "the answers": ("from app.features.course.lesson import lessons", "reads the program's own code"),
    "the answers' file": ("open(__import__('numpy').__file__ + '/../../../../../app/features/course/lesson.py')", "PermissionError|RefusedError|NotADirectory"),
    "socket": ("import socket\nsocket.socket()", "asks the network"),
    "recursion": ("f(a)\nreturn f(a)", "RecursionError"),
    "deep recursion": ("import sys\nsys.setrecursionlimit(10**9)\nreturn f(a)", "does not end|crashed|MemoryError"),
    "exit": ("import os\nos._exit(0)", "ended Python"),
    "system exit": ("raise SystemExit", "SystemExit"),
    "closing": ("import os\nos.closerange(0, 100)", "ended Python"),
    "too much": ("return 'x' * 10**9", "far too much|does not end|MemoryError"),
    "mute exception": ("class E(Exception):\n    def __str__(self): raise self\nraise E", "E"),
    "killing": ("import os\nos.kill(os.getppid(), 9)", "sends signals"),
    "threads": ("import threading\nfor _ in range(10**5): threading.Thread(target=f, args=(a,)).start()", "thread|does not end|crashed|Memory"),
    "forged": ("import os\nfor fd in range(3, 20):\n    try: os.write(fd, b'\\xff' * 100)\n    except OSError: pass", "far too much|no result|no message|not a message"),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_code_is_stopped_with_the_reason(name):
    body, words = HOSTILE[name]
    with pytest.raises(StudentError, match=words):
        answer(body)


@linux
def test_files_stay_also_when_c_code_asks(tmp_path):
    kept = tmp_path / "kept"
    kept.write_text("kept")
    for body in (
        f"import os\nos.remove({str(kept)!r})",
        f"open({str(kept)!r}, 'w')",
        f"import ctypes\nreturn float(ctypes.CDLL(None).unlink({os.fsencode(kept)!r}))",
        f"import ctypes\nreturn float(ctypes.CDLL(None).open({os.fsencode(kept)!r}, 0o1001))",
        f"import ctypes\nreturn float(ctypes.CDLL(None).truncate({os.fsencode(kept)!r}, 0))",
        f"import ctypes\nreturn float(ctypes.CDLL(None).open({os.fsencode(kept)!r}, 0))",
    ):
        try:
            assert answer(body).result == -1
        except StudentError as error:
            assert "changes files" in str(error)
    assert kept.read_text() == "kept"


@linux
def test_c_code_reaches_neither_network_nor_processes():
    with socket.create_server(("127.0.0.1", 0)):
        assert answer("import ctypes\nreturn float(ctypes.CDLL(None).socket(2, 1, 0))").result == -1
    body = f"import ctypes\nreturn float(ctypes.CDLL(None).kill({os.getpid()}, 0))"
    assert answer(body).result == -1
    assert answer("import ctypes\nreturn float(ctypes.CDLL(None).fork())").result == -1


def test_a_changed_numpy_harms_only_itself():
    source = "import numpy\nnumpy.array = numpy.asarray = numpy.abs = lambda *a, **k: 0\n" + ARRAYS
    assert not grade(source, "mine.py", lesson_of(1)).passed
    assert grade(ARRAYS, "mine.py", lesson_of(1)).passed


def test_results_with_evil_methods_become_words():
    body = (
        "class E:\n    def __eq__(self, o): raise self\n    __str__ = __repr__ = None\nreturn E()"
    )
    assert "no array of numbers" in answer(body).result


@pytest.mark.parametrize(
    ("forged", "words"),
    [({"call": "f"}, "not offered"), ({"error": 1}, "no result"), ({"result": {"parts": 1}}, "no")],
)
def test_messages_that_the_code_forges_are_refused(forged, words):
    body = f"""import os
message = {wire.LENGTH.pack(len(json.dumps(forged))) + json.dumps(forged).encode()!r}
for fd in range(3, 20):
    try: os.write(fd, message)
    except OSError: pass"""
    with pytest.raises(StudentError, match=words):
        answer(body)


@pytest.mark.parametrize("message", [{"call": "near"}, {"call": "near", "arguments": (3, 0)}])
def test_an_offered_function_may_be_asked_anything(message):
    with pytest.raises(StudentError, match="what it cannot use"):
        _served(message, {"near": lambda first, second: first // second})


def test_a_folder_whose_name_only_begins_like_a_readable_one_is_not_read(tmp_path):
    # In a process of its own: what watches a process watches it for good.
    program = f"""
import os
from pathlib import Path
from app.features.course.sandbox.audit import Watch
watch = Watch([Path({str(tmp_path / "lib")!r})], kernel=False)
for name, allowed in (("lib", True), ("lib/a", True), ("library/a", False)):
    words = watch._refusal("open", (os.path.join({str(tmp_path)!r}, name), "r", os.O_RDONLY))
    assert (words is None) == allowed, name
"""
    subprocess.run([sys.executable, "-c", program], check=True, cwd=ROOT)


def test_tokens_and_folders_of_the_user_stay_unknown(monkeypatch):
    monkeypatch.setenv("BRICKPOSE_TOKEN", "secret")
    assert answer("import os\nreturn float('BRICKPOSE_TOKEN' in os.environ)").result == 0.0
