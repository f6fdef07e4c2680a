"""What a topic is: its name, type and quality of service, and a message made once for all."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from app.engine.snapshot import Snapshot
from app.ros2.message_types import Message, from_cdr, to_cdr
from app.ros2.source import TopicSource

UNCHANGING = -math.inf
"""The stamp of content that never changes."""


@dataclass(frozen=True, slots=True)
class Quality:
    """Quality of service, as a publisher offers it (REP-2003; nav2)."""

    reliable: bool = True
    """It also matches subscribers that ask for best effort; the other way round does not match."""
    latched: bool = False
    """Late subscribers get the last message (transient local)."""
    depth: int = 10


LATCHED = Quality(latched=True, depth=1)


@dataclass(frozen=True, slots=True)
class Topic:
    """One entry of the list of topics."""

    name: str
    """Without a leading slash, as ``camera/camera_info``."""
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    stamp: Callable[[Snapshot], float | None]
    """Stamp of the content, on the robot's clock [s]; None while there is no content. The same
    stamp means the same content."""
    make: Callable[[TopicSource, Snapshot], Message | bytes]
    """Makes the message, or its CDR where that is faster."""
    rate: str | None = None
    """The setting that limits its rate on live routes; None for no limit."""
    quality: Quality = Quality()
    live: bool = True
    """False: only recorded, because on live routes others publish it."""


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
