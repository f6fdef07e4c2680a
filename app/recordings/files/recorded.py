"""What a recording holds, whoever wrote it."""

from __future__ import annotations

from dataclasses import dataclass, field


class RecordingError(ValueError):
    """A file that cannot be used as a recording; the message says what it is and what would be."""


@dataclass(frozen=True, slots=True)
class RecordedMessage:
    """One message."""

    topic: str
    """As the file has it: recordings of ROS 2 begin it with a slash."""
    type: str
    """``sensor_msgs/msg/LaserScan``."""
    log_time_ns: int
    """When it was recorded [ns since 1970]."""
    cdr: bytes = field(repr=False)
    """The message with its encapsulation header."""
