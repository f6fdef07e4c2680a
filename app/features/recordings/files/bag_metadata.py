"""``metadata.yaml``, which ROS 2's own tools need for a recording (rosbag2 of Jazzy, version 9)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import yaml

from app.features.ros.message_types import type_hash
from app.features.ros.topics import Quality

VERSION = 9
DISTRIBUTION = "jazzy"
"""The ROS distribution of the message definitions."""

FOREVER = {"sec": 9223372036, "nsec": 854775807}
"""The longest duration of ROS 2: no deadline, no end of the lifespan."""
_Dumper: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
"""The version in C takes a tenth of the time, which matters: it runs while the robot drives."""


@dataclass(slots=True)
class RecordedTopic:
    """One topic of a recording."""

    name: str
    """With its slash."""
    type: str
    quality: Quality
    count: int = 0
    """Messages so far."""


@dataclass(slots=True)
class Span:
    """From the first to the last message, by log time [ns since 1970]."""

    start_ns: int
    end_ns: int

    def add(self, time_ns: int) -> None:
        """Extend the span to the time of another message."""
        if time_ns > self.end_ns:
            self.end_ns = time_ns
        elif time_ns < self.start_ns:
            self.start_ns = time_ns


def quality_profiles(quality: Quality) -> list[dict[str, Any]]:
    """Quality of service of a topic's only publisher, in the form of rosbag2."""
    return [
        {
            "history": "keep_last",
            "depth": quality.depth,
            "reliability": "reliable" if quality.reliable else "best_effort",
            "durability": "transient_local" if quality.latched else "volatile",
            "deadline": dict(FOREVER),
            "lifespan": dict(FOREVER),
            "liveliness": "automatic",
            "liveliness_lease_duration": dict(FOREVER),
            "avoid_ros_namespace_conventions": False,
        }
    ]


def channel_metadata(topic: RecordedTopic) -> dict[str, str]:
    """What rosbag2 stores with a topic in the MCAP file."""
    return {
        "offered_qos_profiles": _as_yaml(quality_profiles(topic.quality)),
        "topic_type_hash": type_hash(topic.type),
    }


def bag_metadata(
    file: str, topics: list[RecordedTopic], span: Span | None, facts: Mapping[str, str]
) -> dict[str, Any]:
    """Collect the metadata of a recording.

    Args:
        file: name of its only file, beside ``metadata.yaml``.
        topics: in the order of their first messages.
        span: None while there are no messages.
    """
    start = {"nanoseconds_since_epoch": span.start_ns if span else 0}
    duration = {"nanoseconds": span.end_ns - span.start_ns if span else 0}
    count = sum(topic.count for topic in topics)
    return {
        "version": VERSION,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": start,
        "message_count": count,
        "topics_with_message_count": [_topic(topic) for topic in topics],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file],
        "files": [
            {
                "path": file,
                "starting_time": dict(start),
                "duration": dict(duration),
                "message_count": count,
            }
        ],
        "custom_data": dict(facts),
        "ros_distro": DISTRIBUTION,
    }


def as_text(metadata: dict[str, Any]) -> str:
    """The content of ``metadata.yaml``."""
    return _as_yaml({"rosbag2_bagfile_information": metadata})


def in_file(metadata: dict[str, Any]) -> dict[str, str]:
    """The same metadata for the record ``rosbag2`` in the MCAP file."""
    return {"serialized_metadata": _as_yaml(metadata)}


def _topic(topic: RecordedTopic) -> dict[str, Any]:
    return {
        "topic_metadata": {
            "name": topic.name,
            "type": topic.type,
            "serialization_format": "cdr",
            "offered_qos_profiles": quality_profiles(topic.quality),
            "type_description_hash": type_hash(topic.type),
        },
        "message_count": topic.count,
    }


def _as_yaml(content: object) -> str:
    return str(yaml.dump(content, Dumper=_Plain, sort_keys=False))


class _Plain(_Dumper):  # type: ignore[misc]
    """Writes repeated values in full: not every reader of YAML knows references."""

    def ignore_aliases(self, data: object) -> bool:
        return True
