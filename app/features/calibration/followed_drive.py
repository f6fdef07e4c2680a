"""Follows a drive tick by tick in a thread, while a process of its own works on what it saw."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future, wait
from typing import TypeVar

from app.engine.mailboxes.backlog import Backlog
from app.engine.snapshot import Snapshot
from app.operating_system import set_niceness
from app.worker_process import WorkerProcess
from robot.errors import BrickPoseError
from robot.geometry import Pose2
from robot.localization.estimate import BOUNDED

T = TypeVar("T")

NICENESS = 5
"""Of a process that works beside the control loop."""
LOOK_S = 0.2
"""Interval of checking whether to end, while there are no ticks [s]."""
SILENT_S = 2.0
"""After this time without a tick the drive is given up [s]."""


class FollowingError(BrickPoseError, RuntimeError):
    """The drive cannot be followed to its end; the message says why."""


def give_way(process: WorkerProcess) -> None:
    """Let the process work only with what the control loop and other programs leave it."""
    process.submit(set_niceness, NICENESS)


def start_of(first: Snapshot) -> Pose2:
    """Return where a drive begins, by its first tick: as the filter says if it claims a bound."""
    known = first.integrity.state in BOUNDED and first.pose is not None
    # Else where somebody told that it was, and how its wheels have turned since.
    return first.pose if known and first.pose else first.odometry


def ticks_of(feed: Backlog[Snapshot], stopping: threading.Event) -> Iterator[Snapshot]:
    """Yield ticks as they come.

    Raises:
        FollowingError: none come any more, some were lost, or the thread has to end.
    """
    heard = time.monotonic()
    while True:
        _check_on(stopping)
        snapshot = feed.get(LOOK_S)
        if feed.lost:
            raise FollowingError("this computer is too slow to follow the drive")
        if snapshot is not None:
            heard = time.monotonic()
            yield snapshot
        elif time.monotonic() - heard > SILENT_S:
            raise FollowingError("the robot tells nothing any more")


def ticks_until(
    finish: threading.Event, feed: Backlog[Snapshot], stopping: threading.Event
) -> Iterator[Snapshot | None]:
    """Yield ticks as they come until an event is set; None now and then while there are none.

    Raises:
        FollowingError: the thread has to end.
    """
    while not finish.is_set():
        _check_on(stopping)
        yield feed.get(LOOK_S)


def result_of(job: Future[T], stopping: threading.Event) -> T:
    """Wait for a job of the process, and return its result.

    Raises:
        FollowingError: the thread has to end.
        Exception: of the job.
    """
    while not wait((job,), LOOK_S).done:
        _check_on(stopping)
    return job.result()


def _check_on(stopping: threading.Event) -> None:
    if stopping.is_set():
        raise FollowingError("the program ends")
