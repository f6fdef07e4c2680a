"""RemoteProgram: a program whose robot another process drives, as page and features see it."""

from __future__ import annotations

import gc
import math
import pickle
import signal
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from app.engine.control import ControlLoop
from app.engine.engine import WARM_UP_TICKS
from app.engine.problems import LOG, Problem, ProblemState
from app.engine.program import Program
from app.engine.robot_facts import RobotFacts
from app.engine.snapshot import DrawnMap
from app.features.control.announced import (
    AnnouncedAudience,
    AnnouncedBroadcast,
    AnnouncedLatest,
)
from app.features.control.messages import (
    Begun,
    Ended,
    Follow,
    Go,
    Hangs,
    PutMap,
    Refused,
    SentTick,
    Stop,
    Watched,
)
from app.features.control.parts import PartsReader
from app.features.control.shared_ring import SharedRing
from app.languages.marking import phrase
from app.settings.config import Config
from robot.fields.field import Field
from robot.geometry import Array
from robot.interface import Reading, RobotError
from robot.localization.estimate import Hypothesis

LOOK_S = 0.25
"""Interval of looking who watches no more, and whether the loop shall stop [s]: a robot that rests
without viewers sends something more often, so to look costs nothing then. With 0.05 and 0.1 it cost
0.2 % of a core."""
HELD_LOOK_S = 2.0
"""The same while the process is held still: it costs 0.02 % of a core. What comes, and whoever lets
it go on, is heard at once."""
PATIENCE_S = 2.4
"""A process that was asked to end, or to stop its robot, is killed after this time [s]."""


class ControlProcess:
    """The process that drives the robot, and the server's end of the pipe to it."""

    def __init__(
        self,
        process: BaseProcess,
        connection: Connection,
        ring: SharedRing | None = None,
        shared: Sequence[object] = (),
    ) -> None:
        """``ring`` is memory that both share, ``shared`` what both had before the fork."""
        self.process = process
        self.connection = connection
        self._parts = PartsReader(ring, shared)
        self._sending = threading.Lock()

    def read(self, timeout: float | None = None) -> Any:
        """Return the next message; None if none comes within ``timeout`` [s].

        Raises:
            OSError, EOFError: the process has ended.
        """
        if not self.connection.poll(timeout):
            return None
        return self._parts.read(self.connection.recv_bytes())

    def send(self, order: object) -> None:
        """Send an order; nothing happens if the process has ended."""
        with suppress(OSError), self._sending:
            self.connection.send_bytes(pickle.dumps(order, pickle.HIGHEST_PROTOCOL))

    def begun(self) -> Begun:
        """Wait until a program is built.

        Raises:
            RobotError: the process has ended.
            Exception: whatever there was against it.
        """
        try:
            message = self.read()
        except (OSError, EOFError) as error:
            raise RobotError(self.end()) from error
        if isinstance(message, Refused):
            self.end()
            raise message.error
        assert isinstance(message, Begun)
        return message

    def end(self) -> str:
        """Have the process stop its robot and end; return in words how it ended."""
        with suppress(OSError):
            self.connection.close()
        self.process.join(PATIENCE_S)
        self.kill()
        return _ending(self.process.exitcode)

    def kill(self) -> None:
        """End the process at once, if it has not ended; a real robot then stops by itself."""
        if self.process.exitcode is None:
            self.process.kill()
            self.process.join()


Start = Callable[[Config], ControlProcess]
"""Starts a process that controls the robot of a configuration."""


class RemoteControl(ControlLoop):
    """The loop of a control process."""

    def __init__(self, process: ControlProcess, begun: Begun) -> None:
        super().__init__(begun.facts.spec, begun.scanner)
        self.audience = AnnouncedAudience(self._wake)
        self.every = AnnouncedBroadcast(self._wake)
        self.drawn = AnnouncedLatest(self._wake)
        self._process = process
        self._hangs: tuple[str, ...] = ()
        self._count = 0
        self._held = False

    def hold(self, held: bool) -> None:
        """Note that the process is held still by a signal, or goes on; any thread may call it."""
        self._held = held
        if not held:
            self._wake()

    def _wake(self) -> None:
        """Wake who waits for a command."""
        self.commands.put(None)  # type: ignore[arg-type]

    def run(self, stop: threading.Event) -> None:
        """Take snapshots until ``stop`` is set; the process then stops its robot and ends."""
        self.audience.leave()  # whoever made it
        ended = threading.Event()
        writer = threading.Thread(target=self._write, args=(ended,), name="orders", daemon=True)
        self._process.send(Go())
        writer.start()
        try:
            self._follow(stop)
        finally:
            ended.set()
            self._wake()
            writer.join(PATIENCE_S)
            if self.failure is not None or not self.handed_over:
                self._process.end()

    def where_it_hangs(self, thread: int | None) -> tuple[str, ...]:
        """Return in words which lines of users' files the process is running."""
        return self._hangs

    def _follow(self, stop: threading.Event) -> None:
        """Take what comes until the loop has ended; ask for its end when ``stop`` is set."""
        asked = math.inf
        while time.monotonic() - asked < PATIENCE_S:
            if stop.is_set() and asked == math.inf:
                asked = time.monotonic()
                self._process.send(Stop(self.handed_over))
            try:
                message = self._process.read(HELD_LOOK_S if self._held else LOOK_S)
            except (OSError, EOFError):
                ending = self._process.end()
                self._fail(
                    phrase(
                        f"The process that controls the robot has ended: {ending}; "
                        "choose the field again to start it anew."
                    )
                )
                return
            except Exception as error:  # as of what a feature shows, which cannot be made here
                self._fail(phrase(f"What the robot's process sends cannot be read: {error}"))
                return
            if isinstance(message, Ended):
                self.failure = message.failure
                if asked == math.inf and message.failure is None:
                    self._fail(phrase("The process that controls the robot was asked to end."))
                return
            self._take(message)
        LOG.error("control did not end within %g s", PATIENCE_S)
        self._process.kill()

    def _take(self, message: SentTick | Hangs | None) -> None:
        if isinstance(message, SentTick):
            self._hangs = ()
            self.latest.put(message.snapshot)
            if message.unbroken:
                self.every.put(message.snapshot)
            self._count += 1
            if self._count == WARM_UP_TICKS:
                gc.freeze()
        elif message is not None:
            self._hangs = message.where

    def _fail(self, message: str) -> None:
        LOG.error("%s", message)
        self.failure = message
        last = self.latest.get()
        if last is not None:
            known = last.problems
            noted = (*known.record, Problem(last.stamp, message))
            present = (*known.present, message)
            self.latest.put(last.failed(ProblemState(present, known.count + 1, noted)))

    def _write(self, ended: threading.Event) -> None:
        """Pass on commands, and who watches, until the loop has ended."""
        watched: Watched | None = None
        drawn: DrawnMap | None = None
        while not ended.is_set():
            command = self.commands.get(HELD_LOOK_S if self._held else LOOK_S)
            present = Watched(self.audience.rate, self.every.subscribed)
            if present != watched:
                watched = present
                self._process.send(present)
            newest = self.drawn.get()
            if newest is not drawn:
                drawn = newest
                self._process.send(PutMap(newest))
            if command is not None:
                self._process.send(command)


class DistantRobot:
    """A robot that another process drives."""

    def __init__(self, process: ControlProcess, facts: RobotFacts) -> None:
        self.name = facts.name
        self.spec = facts.spec
        self._process = process

    def read(self) -> Reading:
        """Refuse: only its own process reads it."""
        raise RobotError("another process drives this robot")

    def write(self, velocities: Array) -> Array:
        """Refuse: only its own process drives it."""
        raise RobotError("another process drives this robot")

    def close(self) -> None:
        """Have the process stop the robot and end."""
        self._process.end()


@dataclass(frozen=True)
class RemoteProgram(Program):
    """A program whose robot is driven by another process."""

    process: ControlProcess = field(kw_only=True)
    known: RobotFacts = field(kw_only=True)
    """The facts of the robot."""
    start: Start = field(kw_only=True)
    """Starts another process, if this one has failed."""

    @classmethod
    def of(cls, process: ControlProcess, start: Start) -> RemoteProgram:
        """Return the program that a process is building, as soon as it is built.

        Raises:
            Exception: whatever there is against it.
        """
        begun = process.begun()
        return cls(
            RemoteControl(process, begun),
            DistantRobot(process, begun.facts),
            begun.field,
            begun.config,
            begun.given,
            process=process,
            known=begun.facts,
            start=start,
        )

    @property
    def facts(self) -> RobotFacts:
        """What is known of the robot."""
        return self.known

    def on_field(self, name: str, field: Field, place: Hypothesis | None) -> RemoteProgram:
        """Return the next program, on another field, after this one has handed its robot over.

        Raises:
            Exception: whatever there is against it.
        """
        if self.engine.failure is not None:
            config = replace(self.config, map=name)
            return RemoteProgram.of(self.start(config), self.start)
        self.process.send(Follow(name, field, place))
        return RemoteProgram.of(self.process, self.start)


def _ending(code: int | None) -> str:
    if code is None:
        return phrase("it does not end")
    if code >= 0:
        return phrase(f"exit code {code}")
    with suppress(ValueError):
        return phrase(f"ended by {signal.Signals(-code).name}")
    return phrase(f"ended by signal {-code}")
