"""A process of its own for work that would hold up the program."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import threading
import traceback
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any, TypeVar

import cv2

from app.interruption import uninterrupted
from app.operating_system import children_deaf_to_ctrl_c
from robot.errors import BrickPoseError

S = TypeVar("S")
T = TypeVar("T")


class WorkerEndedError(BrickPoseError, RuntimeError):
    """The process ended before it had done the job."""


@dataclass(frozen=True, eq=False)
class _Job:
    """What the process shall do."""

    message: bytes
    """The pickled function and its argument."""
    future: Future[Any]


class WorkerProcess:
    """One process that does one job after the other, and may be ended at any moment.

    Not an executor of ``concurrent.futures``: that one keeps the writer's end of its pipe, waits
    for ever for the rest of a result whose sender was killed, and the program waits for it.
    """

    def __init__(self) -> None:
        """Start the process; it gets ready while the program goes on."""
        context = multiprocessing.get_context("spawn")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs,), name="worker", daemon=True)
        # Ctrl-C is for the program, which then ends the process.
        with uninterrupted(), children_deaf_to_ctrl_c():
            self._process.start()
        theirs.close()  # so that the pipe ends with the process
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._lock = threading.Lock()
        self._ended = False
        # Nobody waits for this thread: it must not keep the program from ending.
        threading.Thread(target=self._hand_over, name="worker's jobs", daemon=True).start()

    def __enter__(self) -> WorkerProcess:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()

    @property
    def pid(self) -> int:
        """The number of the process."""
        assert self._process.pid is not None
        return self._process.pid

    def submit(self, work: Callable[[S], T], job: S) -> Future[T]:
        """Do a job after those before it.

        Args:
            work: a function of a module, as the process looks it up by name.
            job: its argument, which is sent.

        Returns:
            What will be its result or its error; a ``WorkerEndedError`` if the process ends before
            it is done.

        Raises:
            RuntimeError: the process was ended.
        """
        message = pickle.dumps((work, job), pickle.HIGHEST_PROTOCOL)
        future: Future[T] = Future()
        with self._lock:
            if self._ended:
                raise RuntimeError("the worker's process was ended")
            self._jobs.put(_Job(message, future))
        return future

    def end(self) -> None:
        """End the process at once, even while it works; may be called twice.

        The job that it works on fails, those after it are cancelled.
        """
        with self._lock:
            if not self._ended:
                self._ended = True
                self._process.kill()
                self._jobs.put(None)

    def _hand_over(self) -> None:
        """Give the process its jobs, and their futures what became of them, until the end."""
        while (job := self._jobs.get()) is not None:
            if self._ended:
                job.future.cancel()
            if job.future.set_running_or_notify_cancel():
                self._do(job)
        self._process.join()
        self._ours.close()

    def _do(self, job: _Job) -> None:
        try:
            self._ours.send_bytes(job.message)
            answer = self._ours.recv_bytes()
        except (OSError, EOFError):
            job.future.set_exception(WorkerEndedError("the process ended before the job was done"))
            return
        try:
            done, outcome = pickle.loads(answer)
        except Exception as error:  # as of an error that cannot be made from its own arguments
            done, outcome = False, error
        if done:
            job.future.set_result(outcome)
        else:
            job.future.set_exception(outcome)


def cores() -> int:
    """Return the number of cores that this program may use."""
    if hasattr(os, "sched_getaffinity"):  # not on every system
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _work(connection: Connection) -> None:
    """Do what comes, in the new process: it uses one core and ends when its parent process ends."""
    cv2.setNumThreads(1)
    threading.Thread(target=_end_with_parent, name="parent watch", daemon=True).start()
    while True:
        try:
            message = connection.recv_bytes()
        except (OSError, EOFError):
            return
        connection.send_bytes(_answer(message))


def _answer(message: bytes) -> bytes:
    """Return the pickled pair of whether the job could be done, and its result or error."""
    try:
        work, job = pickle.loads(message)
        return pickle.dumps((True, work(job)), pickle.HIGHEST_PROTOCOL)
    except BaseException as error:  # also SystemExit: it is the job's
        error.add_note("".join(traceback.format_exception(error)))
        try:
            return pickle.dumps((False, error), pickle.HIGHEST_PROTOCOL)
        except Exception:
            return pickle.dumps((False, RuntimeError(repr(error))), pickle.HIGHEST_PROTOCOL)


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
