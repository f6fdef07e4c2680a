"""One published message, made once for all routes that want it."""

from __future__ import annotations

import threading
from functools import cached_property

from app.engine.snapshot import Snapshot
from app.ros2.message_types import Message, from_cdr, to_cdr
from app.ros2.source import TopicSource
from app.ros2.topic import UNCHANGING, Topic


class Published:
    """A message as an object and as bytes; converted at the first use, from any thread."""

    def __init__(self, topic: Topic, stamp: float, source: TopicSource, snapshot: Snapshot) -> None:
        self.topic = topic
        self.stamp = stamp
        """Stamp of the content, on the robot's clock [s]."""
        self.log_time_ns = source.clock.ns(snapshot.stamp)
        """Time of the tick that published it, in ROS time."""
        self.time_ns = self.log_time_ns if stamp == UNCHANGING else source.clock.ns(stamp)
        """Time of the content, in ROS time; that of the tick if the content never changes."""
        self._made = topic.make(source, snapshot)
        self._lock = threading.RLock()

    @cached_property
    def cdr(self) -> bytes:
        """XCDR1, little endian, with its encapsulation header."""
        with self._lock:
            made = self._made
            return made if isinstance(made, bytes) else to_cdr(made, self.topic.type)

    @cached_property
    def message(self) -> Message:
        """The message as an object of rosbags."""
        with self._lock:
            made = self._made
            return from_cdr(made, self.topic.type) if isinstance(made, bytes) else made
