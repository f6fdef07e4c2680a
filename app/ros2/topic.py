"""What a topic is: its name, type and quality of service, and how its messages are made."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from app.engine.snapshot import Snapshot
from app.ros2.message_types import Message
from app.ros2.source import TopicSource

UNCHANGING = -math.inf
"""The stamp of what never changes."""


@dataclass(frozen=True, slots=True)
class Quality:
    """Quality of service, as a publisher offers it (REP-2003; nav2)."""

    reliable: bool = True
    """A subscriber may still ask for best effort; the other way round they would not match."""
    latched: bool = False
    """Who comes later gets the last message: transient local."""
    depth: int = 10


LATCHED = Quality(latched=True, depth=1)


@dataclass(frozen=True, slots=True)
class Topic:
    """One line of the list of topics."""

    name: str
    """Without slash, as ``camera/camera_info``."""
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    stamp: Callable[[Snapshot], float | None]
    """When its content is of, on the robot's clock [s]; None while there is nothing to tell. The
    same stamp is the same content."""
    make: Callable[[TopicSource, Snapshot], Message | bytes]
    """The message, or its CDR where that is quicker to make."""
    rate: str | None = None
    """The setting that limits how often live routes get it; None is as it comes."""
    quality: Quality = Quality()
    live: bool = True
    """False: only recorded, because elsewhere others publish it."""
