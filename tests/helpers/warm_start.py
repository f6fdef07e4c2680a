"""Programs that begin within moments: copies of one process that has imported everything.

For tests to which it does not matter how a program starts. What is copied has no threads, so a copy
goes on as ``python -m app`` does after its imports; it is a child of the tests' process.
"""

from __future__ import annotations

import ctypes
import gc
import inspect
import os
import pickle
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from places import HELPERS, ROOT

LONGEST_REQUEST = 2**16
LONGEST_END_S = 10.0
PR_SET_CHILD_SUBREAPER = 36
CHANGING = frozenset({"PYTEST_CURRENT_TEST"})
"""Variables that no program reads."""
START = f"""
import sys; sys.path.insert(0, {str(HELPERS)!r})
import warm_start; warm_start.be_copied()
"""
PIPES = ("p2cread", "p2cwrite", "c2pread", "c2pwrite", "errread", "errwrite")
_LOCK = threading.Lock()
_usual: dict[str, str] = {}
"""The environment that most programs get; none until somebody has said so."""


class WarmProgram(subprocess.Popen):
    """``python -m app`` with some words: by a copy, where one would do as the program does."""

    def _execute_child(self, *given):
        told = inspect.signature(subprocess.Popen._execute_child).bind(self, *given).arguments
        module = [sys.executable, "-m", "app"]
        unusual = told["env"] is not None or (_usual and _usual != _environment())
        unusual = unusual or sys.platform != "linux"  # others give no child to adopt
        if told["args"][:3] != module or unusual:
            super()._execute_child(*given)
            return
        pipes = (told["p2cread"], told["c2pwrite"], told["errwrite"])
        self.pid = _original().copy(
            told["args"][3:],
            told["cwd"] or Path.cwd(),
            [own if pipe == -1 else pipe for own, pipe in enumerate(pipes)],
        )
        self._child_created = True
        self._close_pipe_fds(*(told[name] for name in PIPES))


class Original:
    """The process that is copied; it ends with the process that has this."""

    def __init__(self) -> None:
        self._ours, theirs = socket.socketpair()
        self._lock = threading.Lock()
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-c", START],
                # BLAS without threads, as the program has it.
                env={**(_usual or _environment()), "OPENBLAS_NUM_THREADS": "1"},
                cwd=ROOT,
                pass_fds=[theirs.fileno()],
                stdin=theirs.fileno(),
            )

    def copy(self, words: Sequence[str], folder: Path, files: Sequence[int]) -> int:
        """Begin a program with these words and standard files; return its process."""
        request = pickle.dumps((list(words), str(folder)))
        assert len(request) < LONGEST_REQUEST
        with self._lock, _adopting():
            socket.send_fds(self._ours, [request], files)
            return int(self._ours.recv(32))


def _original() -> Original:
    with _LOCK:  # a cache lets two threads begin one each
        return _only_original()


@cache
def _only_original() -> Original:
    return Original()


def remember_environment() -> None:
    """Let programs that get the present environment be copies."""
    _usual.update(_environment())


def _environment() -> dict[str, str]:
    return {name: value for name, value in os.environ.items() if name not in CHANGING}


@contextmanager
def _adopting():
    """Be the parent of grandchildren whose own parent ends."""
    system = ctypes.CDLL(None, use_errno=True)
    if system.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0):
        raise OSError(ctypes.get_errno(), "a copy would have no parent")
    try:
        yield
    finally:
        system.prctl(PR_SET_CHILD_SUBREAPER, 0, 0, 0, 0)


def be_copied() -> None:
    """Import all that a program needs, then copy this process at each request.

    Returns in a copy, after the program in it.
    """
    asked = socket.socket(fileno=os.dup(0))
    sys.path.remove(str(HELPERS))
    _get_warm()
    gc.freeze()
    while True:
        request, files, _, _ = socket.recv_fds(asked, LONGEST_REQUEST, 3)
        if not request:
            os._exit(0)
        words, folder = pickle.loads(request)
        read, write = os.pipe()
        parent = os.fork()
        if not parent:
            program = os.fork()
            if program:
                os.write(write, str(program).encode())
                os._exit(0)
            asked.close()
            _become(words, folder, files, (read, write))
            return
        os.waitpid(parent, 0)
        asked.send(os.read(read, 32))
        for each in (read, write, *files):
            os.close(each)


def _become(words, folder, files, others) -> None:
    for own, file in enumerate(files):
        os.dup2(file, own)
    for file in {*files, *others} - {0, 1, 2}:
        os.close(file)
    # Streams remember of what kind their file is.
    sys.stdin = os.fdopen(0, closefd=False)
    sys.stdout = os.fdopen(1, "w", closefd=False)
    sys.stderr = os.fdopen(2, "w", buffering=1, errors="backslashreplace", closefd=False)
    os.chdir(folder)
    sys.argv = [str(Path(folder, "app", "__main__.py")), *words]
    signal.signal(signal.SIGINT, signal.default_int_handler)
    import cv2

    from app.__main__ import main

    cv2.setNumThreads(-1)
    raise SystemExit(main())


def _get_warm() -> None:
    import cv2

    cv2.setNumThreads(0)
    from app.engine.build import build_program
    from app.settings.config import Config

    for robot in ("kinematic", "sim"):
        program = build_program(Config(robot=robot, map="stub"))
        for _ in range(20):
            program.engine.step()
        program.robot.close()
    _wait_alone()


def _wait_alone() -> None:
    """Wait until the last thread has ended: a copy would not have it."""
    until = time.monotonic() + LONGEST_END_S
    while len(list(Path("/proc/self/task").iterdir())) > 1:
        assert time.monotonic() < until, threading.enumerate()
        time.sleep(0.01)
