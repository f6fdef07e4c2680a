"""A serial port of Windows, as COM3: pyserial waits for it, as ``select`` there knows sockets only.

Windows lets one program at a time open a port, so nothing else needs to keep others out.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import serial  # type: ignore[import-untyped, unused-ignore]

from robot.hat.wire.ports import other_ports
from robot.hat.wire.wire import BAUD, TOGETHER_S, PortNotOpenedError

SLICE_S = 0.005
"""Longest wait for a byte before the clock is looked at [s]. It is set once: pyserial sets up the
port anew at each change."""
WRITE_S = 0.05
"""Longest time for a piece to be written [s]; 256 bytes take 22 ms at this speed."""
PIECE = 256
"""Most bytes written at a time. How many of a piece were taken is not told if it fails."""


class WindowsWire:
    """An open port."""

    def __init__(self, device: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Open a port for this program alone.

        Raises:
            PortNotOpenedError: it cannot be opened.
        """
        self._clock = clock
        try:
            self._port = serial.Serial(device, BAUD, timeout=SLICE_S, write_timeout=WRITE_S)
        except (OSError, ValueError) as error:
            raise PortNotOpenedError(_reason(device, str(error))) from error

    def read(self, seconds: float, *, sending: bool) -> bytes:
        """Return what came; wait for it, at most for a time [s] or, while sending, a moment."""
        end = self._clock() + (min(seconds, SLICE_S) if sending else seconds)
        while not (first := self._first(waiting=self._clock() < end)):
            if self._clock() >= end:
                return b""
        time.sleep(TOGETHER_S)
        return first + bytes(self._port.read(self._port.in_waiting))

    def write(self, data: bytes | bytearray) -> int:
        """Send a piece, if the one before has left; return how many bytes."""
        if self._port.out_waiting:
            return 0
        piece = bytes(data[:PIECE])
        try:
            self._port.write(piece)
        except serial.SerialTimeoutException:
            return 0  # it takes nothing: SerialPort gives it up, if that lasts
        return len(piece)

    def unsent(self) -> int:
        """Return how many written bytes have not left yet."""
        return int(self._port.out_waiting)

    def close(self) -> None:
        """Close the port; may be called twice."""
        self._port.close()

    def _first(self, *, waiting: bool) -> bytes:
        count = self._port.in_waiting
        return bytes(self._port.read(count or 1)) if count or waiting else b""


def _reason(device: str, said: str) -> str:
    """Return why a port cannot be opened, and what to do; pyserial tells it in words only."""
    if "FileNotFoundError" in said:
        return f"there is no serial port {device}; {other_ports('COM3')}"
    if "PermissionError" in said:
        return f"another program has {device} open; end it"
    return f"{device} cannot be opened as a serial port: {said}"
