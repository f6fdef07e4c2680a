"""Framing of messages between the program and its DDS process: a length, a number, bytes.

This module does no input or output. It and everything else of BrickPose that the process imports
are light, so that the process starts quickly.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

from robot.errors import BrickPoseError

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
