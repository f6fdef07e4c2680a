"""What a topic is: its name, type and quality of service, and how its messages are made."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from app.engine.snapshot import Snapshot
from app.ros2.message_types import Message
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
