"""What waits for the DDS process: the newest message of each topic."""

from __future__ import annotations

import threading

from app.ros2.published import Published
from app.ros2.topic import Topic


class Mailbox:
    """Bounded by the number of topics; whoever puts something in never waits."""

    def __init__(self) -> None:
        self._waiting: dict[Topic, Published] = {}
        self._latched: dict[Topic, Published] = {}
        self._lock = threading.Lock()
        self.replaced = 0
        """Messages that a newer one took the place of."""

    def put(self, published: Published) -> None:
        """Leave a message; it takes the place of an older one of its topic."""
        topic = published.topic
        with self._lock:
            self.replaced += topic in self._waiting
            self._waiting[topic] = published
            if topic.quality.latched:
                self._latched[topic] = published

    def take_all(self) -> list[Published]:
        """Everything that waits."""
        with self._lock:
            taken, self._waiting = list(self._waiting.values()), {}
            return taken

    def begin_anew(self) -> None:
        """For a process that knows nothing yet: what is latched waits again, the rest is old."""
        with self._lock:
            self._waiting = dict(self._latched)
