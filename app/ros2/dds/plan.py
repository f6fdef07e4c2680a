"""What the DDS process is told at its start: where to take part, what to publish and to hear."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

Kind = str | list[Any]
"""Of a field: a base type's or a message's name, or ``[name, "array" | "sequence", size]``."""

Shapes = dict[str, list[tuple[str, Kind]]]
"""The fields of each message type, in an order in which all parts come before the whole."""


@dataclass(frozen=True)
class Endpoint:
    """One topic, seen from here."""

    topic: str
    """With slash, as ``/robot1/scan``."""
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    type_hash: str = ""
    reliable: bool = True
    latched: bool = False
    depth: int = 1


@dataclass(frozen=True)
class Plan:
    """All of it."""

    domain: int
    namespace: str
    """Of the node, with slash, as ``/`` or ``/robot1``."""
    name: str
    """Of the node."""
    configuration: str | None
    """Cyclone DDS's, in XML; None leaves it to its own environment variable and defaults."""
    confined: bool
    """Whether nothing may come from another machine."""
    shapes: Shapes
    writers: tuple[Endpoint, ...]
    readers: tuple[Endpoint, ...]

    def to_json(self) -> bytes:
        """For the way to the process."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_json(cls, data: bytes) -> Plan:
        """As it arrives."""
        fields = json.loads(data)
        for name in ("writers", "readers"):
            fields[name] = tuple(Endpoint(**field) for field in fields[name])
        return cls(**fields)


def dds_topic(topic: str) -> str:
    """The name in DDS of a topic of ROS 2, as ``rt/scan``."""
    return f"rt{topic}"


def dds_type(name: str) -> str:
    """The name in DDS of a message type, as ``sensor_msgs::msg::dds_::LaserScan_``."""
    package, kind, message = name.split("/")
    return f"{package}::{kind}::dds_::{message}_"
