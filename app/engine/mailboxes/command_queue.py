"""Commands that wait for the engine."""

from __future__ import annotations

import contextlib
import queue

from app.messages.commands import Command

MOST_COMMANDS = 100
"""Taken in one tick, so that a flood of commands does not hold the robot up."""


class CommandQueue(queue.SimpleQueue[Command]):
    """Filled from any thread, emptied by the engine's."""

    def take(self) -> tuple[Command, ...]:
        """Those to be carried out in this tick, oldest first."""
        taken: list[Command] = []
        with contextlib.suppress(queue.Empty):
            while len(taken) < MOST_COMMANDS:
                taken.append(self.get_nowait())
        return tuple(taken)
