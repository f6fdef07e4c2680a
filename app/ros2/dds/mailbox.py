"""Messages that wait for the DDS process: the newest one of each topic."""

from __future__ import annotations

import threading

from app.ros2.topic import Published, Topic


class Mailbox:
    """Holds at most one message per topic; ``put`` never waits."""

    def __init__(self) -> None:
        self._waiting: dict[Topic, Published] = {}
        self._latched: dict[Topic, Published] = {}
        self._lock = threading.Lock()
        self.replaced = 0
        """How many messages were replaced by a newer one."""

    def put(self, published: Published) -> None:
        """Put a message in; it replaces an older one of its topic."""
        topic = published.topic
        with self._lock:
            self.replaced += topic in self._waiting
            self._waiting[topic] = published
            if topic.quality.latched:
                self._latched[topic] = published

    def take_all(self) -> list[Published]:
        """Take all waiting messages out."""
        with self._lock:
            taken, self._waiting = list(self._waiting.values()), {}
            return taken

    def begin_anew(self) -> None:
        """Prepare for a new process: latched messages wait again, the others are dropped as old."""
        with self._lock:
            self._waiting = dict(self._latched)
