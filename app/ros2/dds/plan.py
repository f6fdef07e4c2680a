"""The plan that the DDS process gets at its start: its domain, what to publish and to receive."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

Kind = str | list[Any]
"""A field's type: name of a base type or message, or ``[name, "array" | "sequence", size]``."""

Shapes = dict[str, list[tuple[str, Kind]]]
"""The fields of each message type; the types that it contains come before it."""


@dataclass(frozen=True)
class Endpoint:
    """One topic that the process writes or reads."""

    topic: str
    """With a leading slash, as ``/robot1/scan``."""
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    type_hash: str = ""
    reliable: bool = True
    latched: bool = False
    depth: int = 1


@dataclass(frozen=True)
class Plan:
    """Everything that the process needs to know."""

    domain: int
    namespace: str
    """Namespace of the node, with a leading slash, as ``/`` or ``/robot1``."""
    name: str
    """Name of the node."""
    configuration: str | None
    """Cyclone DDS's configuration in XML; None for its own environment variable and defaults."""
    confined: bool
    """Whether messages from other machines are kept out."""
    shapes: Shapes
    writers: tuple[Endpoint, ...]
    readers: tuple[Endpoint, ...]

    def to_json(self) -> bytes:
        """Encode the plan, to send it to the process."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_json(cls, data: bytes) -> Plan:
        """Decode a plan that the process received."""
        fields = json.loads(data)
        for name in ("writers", "readers"):
            fields[name] = tuple(Endpoint(**field) for field in fields[name])
        return cls(**fields)


def dds_topic(topic: str) -> str:
    """The DDS name of a ROS 2 topic, as ``rt/scan``."""
    return f"rt{topic}"


def dds_type(name: str) -> str:
    """The DDS name of a message type, as ``sensor_msgs::msg::dds_::LaserScan_``."""
    package, kind, message = name.split("/")
    return f"{package}::{kind}::dds_::{message}_"
