"""The topic ``tape_rays``: how many rays of each scan meet tape."""

import numpy as np

from app.engine.snapshot import Snapshot
from app.features.ros.message_types import Message, new
from app.features.ros.source import TopicSource
from app.features.ros.topics import Topic


def topics() -> tuple[Topic, ...]:
    """Return the topic; each scan, by its stamp, is a message."""
    return (Topic("tape_rays", "std_msgs/msg/Float64", _stamp, _message),)


def _stamp(snapshot: Snapshot) -> float | None:
    seen = snapshot.filter.line_scan
    return None if seen is None else seen.scan.stamp


def _message(_source: TopicSource, snapshot: Snapshot) -> Message:
    seen = snapshot.filter.line_scan
    count = 0 if seen is None else np.isfinite(seen.scan.ranges).sum()
    return new("std_msgs/msg/Float64", data=float(count))
