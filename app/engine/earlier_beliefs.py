"""Beliefs before each change by a person, to undo it."""

from __future__ import annotations

from collections import deque
from typing import Any

from app.engine.checkpoint import Checkpoint, CheckpointError, CheckpointWriter

MOST_UNDOABLE = 20
"""Most changes of the belief that can be undone."""
MOST_BYTES = 64_000_000
"""All beliefs together take no more; the oldest are forgotten."""


class EarlierBeliefs:
    """The newest beliefs, as copies that nothing changes any more."""

    def __init__(self, most: int = MOST_UNDOABLE) -> None:
        self._beliefs: deque[Checkpoint] = deque(maxlen=most)

    def __len__(self) -> int:
        """How many changes can be undone."""
        return len(self._beliefs)

    def keep(self, belief: tuple[Any, ...], unchanging: tuple[Any, ...]) -> None:
        """Keep a belief; the copy shares what never changes."""
        self.add(self.copy(belief, unchanging))

    def copy(self, belief: tuple[Any, ...], unchanging: tuple[Any, ...]) -> Checkpoint | None:
        """Return a copy for ``add``; None if something cannot be copied."""
        try:
            return CheckpointWriter(unchanging).keep(belief)
        except CheckpointError:  # a user's own model holds what cannot be copied
            return None

    def add(self, copy: Checkpoint | None) -> None:
        """Keep a copy; without one there is no way back to what is before it either."""
        if copy is None:
            self.clear()
        else:
            self._beliefs.append(copy)
            while len(self._beliefs) > 1 and sum(item.size for item in self._beliefs) > MOST_BYTES:
                self._beliefs.popleft()

    def restore(self) -> Any:
        """Return the belief before the last change, and forget it here."""
        return self._beliefs.pop().restore()

    def clear(self) -> None:
        """Forget all: after the robot was put elsewhere, they are of no use."""
        self._beliefs.clear()
