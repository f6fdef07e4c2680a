"""The messages of a recording, whichever program wrote it."""

from __future__ import annotations

from dataclasses import dataclass, field

from robot.errors import BrickPoseError

CDR, ROS1 = "cdr", "ros1"
"""Encodings of messages: of ROS 2, and of ROS 1."""


class RecordingError(BrickPoseError, ValueError):
    """A recording cannot be read or made; the message says why, and what is valid."""


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """One message."""

    topic: str
    """The topic's name in the file; in recordings of ROS 2, it begins with a slash."""
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    log_time_ns: int
    """When it was recorded [ns since 1970]."""
    cdr: bytes = field(repr=False)
    """The message: in CDR with its encapsulation header."""
