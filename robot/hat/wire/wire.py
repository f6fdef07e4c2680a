"""What ``SerialPort`` needs of an open port."""

from __future__ import annotations

from typing import Protocol

from robot.errors import BrickPoseError

BAUD = 115_200
TOGETHER_S = 0.003
"""How long to wait for the rest of a line [s]; a line of 21 bytes takes 2 ms to arrive. Waking up
for each part of it would double the processor load."""


class Wire(Protocol):
    """An open port. Each method raises ``OSError`` when the port is gone."""

    def read(self, seconds: float, *, sending: bool) -> bytes:
        """Return what came; wait for it, at most for a time [s].

        Args:
            seconds: how long to wait.
            sending: return as soon as there is room for bytes to send, too.
        """
        ...

    def write(self, data: bytes | bytearray) -> int:
        """Send as much as there is room for, without waiting; return how many bytes."""
        ...

    def unsent(self) -> int:
        """Return how many written bytes have not left yet."""
        ...

    def close(self) -> None:
        """Close the port; may be called twice."""
        ...


class PortNotOpenedError(BrickPoseError, OSError):
    """The port cannot be opened; the message says why, and the cure."""
