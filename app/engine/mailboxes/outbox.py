"""An outbox: values that wait to be sent to one reader; bounded, however slow the reader is."""

from __future__ import annotations

import math
import threading
from collections import deque
from typing import Generic, TypeVar

T = TypeVar("T")


class Outbox(Generic[T]):
    """A queue for each name; filled by one thread, emptied by another."""

    def __init__(self, most_size: float = math.inf) -> None:
        """Beyond ``most_size``, in the unit of ``put``, older values of a name are dropped."""
        self._most_size = most_size
        self._queues: dict[str, deque[tuple[T, int]]] = {}
        self._size = 0
        self._lock = threading.Lock()

    def put(self, name: str, value: T, most: int = 1, size: int = 0) -> None:
        """Append a value; at most ``most`` of this name wait, and the newest is always kept."""
        with self._lock:
            queue = self._queues.setdefault(name, deque())
            queue.append((value, size))
            self._size += size
            while len(queue) > 1 and (len(queue) > most or self._size > self._most_size):
                self._size -= queue.popleft()[1]

    def take(self) -> T | None:
        """Take the oldest value of the name whose turn it is; None if nothing waits."""
        with self._lock:
            for name, queue in self._queues.items():
                value, size = queue.popleft()
                self._size -= size
                del self._queues[name]
                if queue:
                    self._queues[name] = queue  # behind all others
                return value
        return None

    def drop(self, name: str) -> None:
        """Drop all waiting values of a name."""
        with self._lock:
            self._size -= sum(size for _, size in self._queues.pop(name, ()))
