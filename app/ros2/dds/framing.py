"""Messages between the program and its DDS process: a length, a number, bytes; no input or output.

This module and all that the process imports from us are light: the process is to start quickly.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator

HEADER = struct.Struct("<IH")
"""Bytes that follow, and what they are: a topic's place in the plan, or one of those below."""

PLAN = 0xFFFF
"""To the process, first: what it is to publish and to hear, in JSON."""
READY = 0xFFFE
"""From the process: it publishes and hears."""
ALIVE = 0xFFFD
"""From the process, at least each ``ALIVE_S``."""
WORDS = 0xFFFC
"""From the process: why it ends, in words."""
TROUBLE = 0xFFFB
"""From the process: a topic that it cannot publish, in words; it goes on."""

ALIVE_S = 1.0


class FramingError(ValueError):
    """Bytes that nobody who keeps to this form sends."""


def header(number: int, payload: bytes) -> bytes:
    """What goes before a payload."""
    return HEADER.pack(len(payload), number)


class Frames:
    """Puts together what arrives in pieces."""

    def __init__(self, longest: int) -> None:
        self._longest = longest
        self._waiting = bytearray()

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Each whole message: its number and its payload.

        Raises:
            FramingError: one is said to be longer than any may be.
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
