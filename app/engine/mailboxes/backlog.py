"""A backlog: a queue that loses new values when it is full, and counts them."""

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
        """At most ``most`` values wait; 0 means that the writers keep to a limit.

        Writers that come at the same moment may each find the last room.
        """
        self.lost = 0
        """Number of values that found no room."""
        self._most = most
        # In C: a put or get never waits for a lock that another thread holds.
        self._waiting: queue.SimpleQueue[T] = queue.SimpleQueue()

    def __len__(self) -> int:
        return self._waiting.qsize()

    def put(self, value: T) -> None:
        """Put a value in if there is room; else count it as lost."""
        if 0 < self._most <= self._waiting.qsize():
            self.lost += 1
        else:
            self._waiting.put(value)

    def get(self, timeout: float = 0.0) -> T | None:
        """Return the oldest waiting value; None if none comes within ``timeout`` [s]."""
        try:
            return self._waiting.get(timeout > 0, timeout)
        except queue.Empty:
            return None

    def take(self) -> tuple[T, ...]:
        """Take out the oldest ``MOST_TAKEN`` values, oldest first."""
        return tuple(islice(iter(self.get, None), MOST_TAKEN))
