"""Beliefs before each change by a person, to undo it."""

from __future__ import annotations

from collections import deque
from typing import Any

from app.engine.checkpoint import Checkpoint, CheckpointError, CheckpointWriter

MOST_UNDOABLE = 20
"""Most changes of the belief that can be undone."""


class EarlierBeliefs:
    """The newest beliefs, as copies that nothing changes any more."""

    def __init__(self) -> None:
        self._beliefs: deque[Checkpoint] = deque(maxlen=MOST_UNDOABLE)

    def __len__(self) -> int:
        """How many changes can be undone."""
        return len(self._beliefs)

    def keep(self, belief: tuple[Any, ...], unchanging: tuple[Any, ...]) -> None:
        """Keep a belief; the copy shares what never changes."""
        try:
            self._beliefs.append(CheckpointWriter(unchanging).keep(belief))
        except CheckpointError:  # a user's own model holds what cannot be copied
            self._beliefs.clear()

    def restore(self) -> Any:
        """Return the belief before the last change, and forget it here."""
        return self._beliefs.pop().restore()

    def clear(self) -> None:
        """Forget all: after the robot was put elsewhere, they are of no use."""
        self._beliefs.clear()
