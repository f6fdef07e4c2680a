"""A queue that loses new values when it is full, and counts them."""

from __future__ import annotations

import queue
from itertools import islice
from typing import Generic, TypeVar

T = TypeVar("T")

MOST_TAKEN = 100
"""Most values taken at a time, so that a flood of commands does not delay the robot."""


class Backlog(Generic[T]):
    """Values that wait for one reader, oldest first."""

    def __init__(self, most: int = 0) -> None:
        """At most ``most`` values wait; 0 means that the writers keep to a limit."""
        self.lost = 0
        """Number of values that found no room."""
        self._waiting: queue.Queue[T] = queue.Queue(most)

    def __len__(self) -> int:
        return self._waiting.qsize()

    def put(self, value: T) -> None:
        """Put a value in if there is room; else count it as lost."""
        try:
            self._waiting.put_nowait(value)
        except queue.Full:
            self.lost += 1

    def get(self, timeout: float = 0.0) -> T | None:
        """Return the oldest waiting value; None if none comes within ``timeout`` [s]."""
        try:
            return self._waiting.get(timeout=timeout)
        except queue.Empty:
            return None

    def take(self) -> tuple[T, ...]:
        """Take out the oldest ``MOST_TAKEN`` values, oldest first."""
        return tuple(islice(iter(self.get, None), MOST_TAKEN))
