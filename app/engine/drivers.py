"""Notes who drives the robot, and stops it when the last driver leaves."""

from __future__ import annotations

import threading
import time
from collections.abc import Hashable

from app.engine.commands import RULES
from app.engine.mailboxes.backlog import Backlog
from app.messages.commands import Command, StopCommand


class Drivers:
    """Viewers and other clients that drive the robot; any thread may call it."""

    def __init__(self, commands: Backlog[Command], timeout: float) -> None:
        self._commands = commands
        self._timeout = timeout
        self._last: dict[Hashable, float] = {}
        """When each driver last sent a drive command, on the computer's clock [s]."""
        self._lock = threading.Lock()

    def took(self, driver: Hashable, command: Command) -> None:
        """Note that a driver put a command into the queue."""
        with self._lock:
            if RULES[type(command)].drives:
                self._last[driver] = time.monotonic()
            elif isinstance(command, StopCommand):
                self._last.clear()

    def leave(self, driver: Hashable) -> None:
        """Forget a viewer who leaves; stop the robot if only this viewer drove it."""
        with self._lock:
            drove = self._last.pop(driver, None) is not None
            recent = time.monotonic() - self._timeout
            if drove and all(last < recent for last in self._last.values()):
                self._commands.put(StopCommand(type="stop"))
