"""Follows a drive in a thread, while a process of its own works on what it saw.

In a thread, that work would take Python's lock from the control loop.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass

from app.engine.mailboxes.backlog import Backlog
from app.engine.problems import LOG
from app.engine.program import Program
from app.engine.snapshot import Snapshot
from app.worker_process import WorkerProcess
from robot.errors import BrickPoseError
from robot.worker_thread import WorkerThread

PATIENCE_S = 3.0


@dataclass(frozen=True)
class FollowedTicks:
    """What the work on a drive is done with."""

    feed: Backlog[Snapshot]
    """All ticks since the beginning."""
    subscription: ExitStack
    """Closed, there are no more ticks."""
    process: WorkerProcess
    stopping: threading.Event
    """Set when the work has to end."""


class DriveFollower:
    """A thread that there is only while a drive is followed; for any thread."""

    def __init__(
        self,
        program: Program,
        name: str,
        most_waiting: int,
        work: Callable[[FollowedTicks], None],
        failed: Callable[[str], None],
    ) -> None:
        """Prepare to follow.

        Args:
            program: whose ticks are followed.
            name: what the work makes.
            most_waiting: most ticks that wait for the thread.
            work: collects a drive, and lets the process work on it.
            failed: called with what went wrong, if something did.
        """
        self._program = program
        self._name = name
        self._most_waiting = most_waiting
        self._work = work
        self._failed = failed
        self._thread: WorkerThread | None = None

    @property
    def running(self) -> bool:
        """Whether a drive is followed, or worked on."""
        return self._thread is not None and self._thread.alive

    def begin(self) -> None:
        """Follow from the present tick on; none may be followed yet."""
        # Subscribed here: the thread may begin only after the next tick.
        subscription = ExitStack()
        feed = subscription.enter_context(self._program.engine.every.subscribe(self._most_waiting))
        self._thread = WorkerThread(
            self._name,
            lambda stopping: self._run(feed, subscription, stopping),
            owner=f"the {self._name}",
            patience=PATIENCE_S,
        )
        self._thread.start()

    def wait(self, seconds: float) -> None:
        """Wait for the end of the work, at most for a time [s]."""
        if self._thread is not None:
            self._thread.wait(seconds)

    def close(self) -> None:
        """End the thread; may be called twice."""
        if self._thread is not None:
            self._thread.stop()

    def _run(
        self, feed: Backlog[Snapshot], subscription: ExitStack, stopping: threading.Event
    ) -> None:
        try:
            with subscription, WorkerProcess() as process:
                self._work(FollowedTicks(feed, subscription, process, stopping))
        except BrickPoseError as error:
            self._failed(str(error))
        except Exception as error:
            LOG.exception("the %s failed", self._name)
            self._failed(str(error))
