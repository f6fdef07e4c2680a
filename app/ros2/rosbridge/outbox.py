"""Messages that wait to be sent to one client; bounded, however slow the client is."""

from __future__ import annotations

import threading
from collections import deque

MOST_BYTES = 16_000_000
"""Most bytes that wait for one client; beyond it, older messages of a name are dropped."""

Data = str | bytes


class Outbox:
    """A queue for each name; filled by one thread, emptied by another."""

    def __init__(self) -> None:
        self._queues: dict[str, deque[Data]] = {}
        self._size = 0
        self._lock = threading.Lock()

    def put(self, name: str, data: Data, most: int) -> None:
        """Append a message; at most ``most`` of this name wait, and the newest is always kept."""
        with self._lock:
            queue = self._queues.setdefault(name, deque())
            queue.append(data)
            self._size += len(data)
            while len(queue) > 1 and (len(queue) > most or self._size > MOST_BYTES):
                self._size -= len(queue.popleft())

    def take(self) -> Data | None:
        """Take the oldest message of the name whose turn it is; None if nothing waits."""
        with self._lock:
            for name, queue in self._queues.items():
                data = queue.popleft()
                self._size -= len(data)
                del self._queues[name]
                if queue:
                    self._queues[name] = queue  # behind all others
                return data
        return None

    def drop(self, name: str) -> None:
        """Drop all waiting messages of a name."""
        with self._lock:
            self._size -= sum(map(len, self._queues.pop(name, ())))
