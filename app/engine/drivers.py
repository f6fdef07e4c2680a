"""Who drives the robot: what somebody drove does not go on when they are gone."""

from __future__ import annotations

import threading
import time
from collections.abc import Hashable

from app.engine.mailboxes.command_queue import CommandQueue
from app.messages.commands import Command, DriveCommand, FigureEightCommand, StopCommand


class Drivers:
    """Viewers and clients of all kinds; from any thread."""

    def __init__(self, commands: CommandQueue, timeout: float) -> None:
        self._commands = commands
        self._timeout = timeout
        self._last: dict[Hashable, float] = {}
        """When each that drives last said so, on the computer's clock [s]."""
        self._lock = threading.Lock()

    def took(self, who: Hashable, command: Command) -> None:
        """Note whose command was put into the queue."""
        with self._lock:
            if isinstance(command, (DriveCommand, FigureEightCommand)):
                self._last[who] = time.monotonic()
            elif isinstance(command, StopCommand):
                self._last.clear()

    def leave(self, who: Hashable) -> None:
        """Stop the robot if this one was driving it, and nobody else is."""
        with self._lock:
            drove = self._last.pop(who, None) is not None
            recent = time.monotonic() - self._timeout
            if drove and all(last < recent for last in self._last.values()):
                self._commands.put(StopCommand(type="stop"))
