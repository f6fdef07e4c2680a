"""Decides who drives: one client at a time, until another takes over. A stop holds for all."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from app.engine.commands import check, row_of
from app.engine.driver import Driver
from app.engine.mailboxes.backlog import Backlog
from app.engine.program import Program
from app.messages.commands import Command
from app.messages.driving_commands import DriveCommand, StopCommand, TakeCommand
from robot.errors import CommandError

SILENCE = 1.0
"""A client that sends no drive command for this time [s] no longer drives."""
RETURN_S = 5.0
"""A client heard within this time after a stop was taken over [s] may have begun before it."""


@dataclass(slots=True)
class _Gesture:
    """Drive commands of a client without a pause of a second between them."""

    begun: float
    last: float
    by_hand: bool = False
    """Whether it holds the robot by hand, or had its journey kept up here: not a programme that it
    renews itself, and goes on with when it is back."""


@dataclass(frozen=True, slots=True)
class DriveState:
    """Who drives now."""

    driver: Driver | None
    """The client that has the drive; None while nobody drives."""
    stopped: bool
    """Whether a stop holds: drive commands are refused until somebody takes the drive."""


class Drivers:
    """Passes commands on to the engine, but drive commands of one client only; for any thread.

    If nobody drives, the first client that sends a drive command gets the drive. It keeps it until
    a second after its last drive command. A stop by any client holds for all clients. It ends when
    it is a second old and a client drives that began after it; a client that only continues what it
    did before the stop is refused. Of the clients of one person, the pages of one browser, the one
    drives that began last. ``TakeCommand`` ends a stop at once, and gives its client the
    drive: a page sends it when somebody presses a key again.
    """

    def __init__(
        self,
        commands: Backlog[Command],
        timeout: float,
        clock: Callable[[], float] = time.monotonic,
        *,
        stopped: bool = False,
    ) -> None:
        """Begin while nobody drives.

        Args:
            commands: the engine's queue.
            timeout: how long a drive command holds [s].
            clock: the computer's time [s].
            stopped: whether a stop already holds, from the program before this one.
        """
        self._commands = commands
        self._timeout = timeout
        self._clock = clock
        self._driver: Driver | None = None
        self._gestures: dict[Driver, _Gesture] = {}
        """The last drive commands of each client, also refused ones."""
        self._stopped = clock() if stopped else None
        """When the current stop was given [s]."""
        self._returning_until = clock() + RETURN_S if stopped else -math.inf
        """A client whose first command comes until then may have begun to drive before the stop."""
        self._lock = threading.Lock()

    @classmethod
    def of(cls, program: Program) -> Drivers:
        """Return the drivers of a program."""
        timeout = program.config.drive.cmd_vel_timeout
        return cls(program.engine.commands, timeout, stopped=program.stopped)

    @property
    def state(self) -> DriveState:
        """Who drives now."""
        with self._lock:
            return DriveState(self._current(), self._stopped is not None)

    def check(self, driver: Driver, command: Command, program: Program) -> None:
        """Refuse a command that is not allowed; who does not drive is told that before all else.

        Raises:
            CommandError: the command is refused; the message says why.
        """
        try:
            check(command, program)
        except CommandError:
            if row_of(command).drives:
                self.require_free(driver)
            raise

    def put(self, driver: Driver, command: Command) -> None:
        """Pass a client's command on to the engine.

        Raises:
            CommandError: another client drives, or a stop holds; the message says what to do.
        """
        with self._lock:
            if isinstance(command, TakeCommand):
                self._take(driver)
                return
            if isinstance(command, StopCommand):
                self._driver, self._stopped = None, self._clock()
            elif row_of(command).drives:
                self._drive(driver)
                self._gestures[driver].by_hand = isinstance(command, DriveCommand)
            self._commands.put(command)

    def renew(self, driver: Driver, command: Command) -> bool:
        """Pass on a command that continues what a client does; False if it no longer drives."""
        with self._lock:
            drives = self._current() is driver
            if drives:
                gesture = self._gestures[driver]
                gesture.last, gesture.by_hand = self._clock(), True
                self._commands.put(command)
            return drives

    def require_free(self, driver: Driver) -> None:
        """Refuse a command that would interrupt another client that drives.

        Raises:
            CommandError: another client drives; the message says what to do.
        """
        with self._lock:
            self._require_free(driver)

    def refuse(self, driver: Driver) -> None:
        """Stop if a client's drive command cannot be read, unless another client drives."""
        with self._lock:
            if self._current() in (None, driver):
                self._commands.put(StopCommand(type="stop"))

    def leave(self, driver: Driver) -> None:
        """Forget a client that leaves; stop the robot if that client drove it by hand.

        A programme that the client renewed itself stands as soon as nobody renews it, and waits
        for it: a page whose network breaks leaves, too, and comes back.
        """
        with self._lock:
            gesture = self._gestures.pop(driver, None)
            if gesture is not None and self._driver is driver:
                self._driver = None
                if gesture.by_hand and self._clock() - gesture.last < self._timeout:
                    self._commands.put(StopCommand(type="stop"))

    def _take(self, driver: Driver) -> None:
        self._stopped = None
        if self._current() not in (None, driver):
            # What the client ordered must not continue without it.
            self._commands.put(StopCommand(type="stop"))
        self._driver = driver
        # A page may take the drive after the first command by which it drives.
        earlier = self._gestures.get(driver)
        by_hand = earlier is not None and earlier.by_hand
        self._gestures[driver] = _Gesture(self._clock(), self._clock(), by_hand)

    def _drive(self, driver: Driver) -> None:
        stamp = self._clock()
        gesture = self._gestures.get(driver)
        if gesture is None and stamp < self._returning_until:
            self._gestures[driver] = gesture = _Gesture(-math.inf, stamp)
        elif gesture is None or stamp - gesture.last >= SILENCE:
            self._gestures[driver] = gesture = _Gesture(stamp, stamp)
        gesture.last = stamp
        self._require_free(driver)
        current = self._current()
        if current not in (None, driver) and gesture.begun <= self._gestures[current].begun:
            raise CommandError("another page of yours drives; press again to drive from this one")
        if self._stopped is not None:
            if gesture.begun < self._stopped or stamp - self._stopped < SILENCE:
                raise CommandError("a stop holds; take over, or release the controls for a second")
            self._stopped = None
        self._driver = driver

    def _require_free(self, driver: Driver) -> None:
        current = self._current()
        if current is not None and current.person != driver.person:
            raise CommandError(f"{current.name} drives; take over to drive yourself")

    def _current(self) -> Driver | None:
        driver = self._driver
        if driver is not None and self._clock() - self._gestures[driver].last >= SILENCE:
            self._driver = None
        return self._driver
