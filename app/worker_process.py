"""A process of its own for work that would hold up the program."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from typing import TypeVar

import cv2

S = TypeVar("S")
T = TypeVar("T")


class WorkerProcess:
    """A pool of one process, so that killing it loses no other process's job."""

    def __init__(self) -> None:
        """Start the process; it gets ready while the program goes on."""
        context = multiprocessing.get_context("spawn")
        self._pool = ProcessPoolExecutor(1, mp_context=context, initializer=_begin)
        others = set(multiprocessing.active_children())
        # A process inherits what is blocked: Ctrl-C is for the program, which then ends it.
        signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT,))
        try:
            self._pool.submit(os.getpid)
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT,))
        self._processes = set(multiprocessing.active_children()) - others

    def __enter__(self) -> WorkerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    def submit(self, work: Callable[[S], T], job: S) -> Future[T]:
        """Do a job after those before it; ``work`` is a function of a module, not a closure."""
        return self._pool.submit(work, job)

    def end(self) -> None:
        """End the process at once, even while it works."""
        for process in self._processes:
            process.terminate()
        self._pool.shutdown(wait=False, cancel_futures=True)


def _begin() -> None:
    """Set up a new process: it uses one core and ends when its parent process ends."""
    cv2.setNumThreads(1)
    threading.Thread(target=_end_with_parent, name="parent watch", daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
