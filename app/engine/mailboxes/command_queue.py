"""Commands that wait for the engine."""

from __future__ import annotations

import contextlib
import queue

from app.messages.commands import Command

MOST_COMMANDS = 100
"""Most commands taken in one tick, so that a flood of them does not delay the robot."""


class CommandQueue(queue.SimpleQueue[Command]):
    """Queue that any thread may fill and the engine's thread empties."""

    def take(self) -> tuple[Command, ...]:
        """Take out the commands for this tick, oldest first."""
        taken: list[Command] = []
        with contextlib.suppress(queue.Empty):
            while len(taken) < MOST_COMMANDS:
                taken.append(self.get_nowait())
        return tuple(taken)
