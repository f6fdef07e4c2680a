"""ControlLoop: what everybody else sees of the engine, in whichever process it runs."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Sequence

from app.engine.mailboxes.backlog import Backlog
from app.engine.mailboxes.broadcast import Broadcast
from app.engine.mailboxes.latest import Latest
from app.engine.rest import Audience
from app.engine.snapshot import DrawnMap, Snapshot
from app.messages.commands import Command
from robot.description.spec import RobotSpec
from robot.scanning.line_scanner import LineScanner


class ControlLoop(ABC):
    """The loop that owns the robot: commands go in, snapshots come out; any thread may use it."""

    def __init__(self, spec: RobotSpec, scanner: LineScanner | None) -> None:
        """``spec`` and ``scanner`` are those that the first tick begins with."""
        self.latest: Latest[Snapshot] = Latest()
        self.every: Broadcast[Snapshot] = Broadcast()
        self.commands: Backlog[Command] = Backlog()
        self.audience = Audience()
        """Who looks at ``latest``; while nobody does and the robot stands, the camera rests."""
        self.failure: str | None = None
        """Why the loop failed; None while it has not."""
        self.handed_over = False
        """Whether another loop goes on with the robot: at the end it stands, but is open."""
        self.drawn: Latest[DrawnMap | None] = Latest()
        """Takes the map that is drawn by driving, for snapshots."""
        self._first = spec, scanner

    @property
    def spec(self) -> RobotSpec:
        """The robot as it is known at the newest tick."""
        latest = self.latest.get()
        return self._first[0] if latest is None else latest.spec

    @property
    def scanner(self) -> LineScanner:
        """What finds tape in pictures at the newest tick."""
        latest = self.latest.get()
        scanner = self._first[1] if latest is None else latest.filter.scanner
        assert scanner is not None  # a program has one; drives without a filter need none
        return scanner

    def publish(self, snapshot: Snapshot) -> None:
        """Publish the snapshot of a tick to all readers."""
        self.latest.put(snapshot)
        self.every.put(snapshot)

    @abstractmethod
    def run(self, stop: threading.Event) -> None:
        """Work until ``stop`` is set; close the robot whatever happens, unless it is handed over.

        A failure is logged once and published, so readers do not take the last snapshot for a
        present one.
        """

    @abstractmethod
    def where_it_hangs(self, thread: int | None) -> Sequence[str]:
        """Return in words which lines of users' files it is running.

        Args:
            thread: the ``ident`` of the thread that called ``run``.
        """
