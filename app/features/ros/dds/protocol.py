"""What the program and its DDS process tell each other: a plan first, then numbered messages.

This module does no input or output. It and everything else of BrickPose that the process imports
are light, so that the process starts quickly.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from robot.errors import BrickPoseError

Kind = str | list[Any]
"""A field's type: name of a base type or message, or ``[name, "array" | "sequence", size]``."""

Shapes = dict[str, list[tuple[str, Kind]]]
"""The fields of each message type; the types that it contains come before it."""
HEADER = struct.Struct("<IH")
"""Length and number of the payload; the number is a topic's index in the plan, or one of those
below."""
PLAN = 0xFFFF
"""To the process, first: the plan of what to publish and to receive, in JSON."""
READY = 0xFFFE
"""From the process: it publishes and receives."""
ALIVE = 0xFFFD
"""From the process, as a sign of life: at least every 2 ``ALIVE_S``."""
WORDS = 0xFFFC
"""From the process: why it ends, in words."""
TROUBLE = 0xFFFB
"""From the process: a message that it cannot pass on, in words; the process goes on."""
ALIVE_S = 1.0


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


class FramingError(BrickPoseError, ValueError):
    """The bytes do not follow this framing."""


def header(number: int, payload: bytes) -> bytes:
    """The header of a payload."""
    return HEADER.pack(len(payload), number)


class Frames:
    """Assembles messages that arrive in pieces."""

    def __init__(self, longest: int) -> None:
        self._longest = longest
        self._waiting = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Take more bytes; yield the number and payload of each complete message.

        Raises:
            FramingError: the length of a message is above the limit.
        """
        self._waiting += data
        while len(self._waiting) >= HEADER.size:
            length, number = HEADER.unpack_from(self._waiting)
            if length > self._longest:
                raise FramingError(
                    f"a message of {length} bytes; at most {self._longest} are valid"
                )
            end = HEADER.size + length
            if len(self._waiting) < end:
                return
            payload = bytes(self._waiting[HEADER.size : end])
            del self._waiting[:end]
            yield number, payload
