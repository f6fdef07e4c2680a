"""The serial port that a Build HAT is on; and how the motors are stopped that nobody drives."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable
from pathlib import Path

from robot.errors import PortError
from robot.hat.protocol import commands
from robot.hat.wire.ports import other_ports
from robot.hat.wire.wire import PortNotOpenedError

if sys.platform == "win32":
    from robot.hat.wire.windows import WindowsWire as SystemWire
else:
    from robot.hat.wire.unix import UnixWire as SystemWire

STUCK_S = 3.0
"""A port that takes no byte for this time is given up [s]."""

MODEL = Path("/proc/device-tree/model")
RP1_MODELS = re.compile(r"Raspberry Pi (?:5|500|Compute Module 5)\b")
PATIENCE_S = 1.0
"""Longest time for sending the stop [s]; a line of 63 bytes takes 5 ms."""


def find_device(model: Path = MODEL) -> str:
    """Return the serial port on this Pi's header; on a Pi 5 /dev/serial0 is another connector.

    Raises:
        PortError: no Pi has this operating system.
    """
    if sys.platform == "win32":
        raise PortError(f"a Build HAT is on a Raspberry Pi; {other_ports('COM3')}")
    try:
        name = model.read_text(encoding="utf-8", errors="replace")
    except OSError:
        # Not a Raspberry Pi: opening the port will say so.
        name = ""
    return "/dev/ttyAMA0" if RP1_MODELS.search(name) else "/dev/serial0"


class SerialPort:
    """An open port; written bytes wait here until the port takes them."""

    def __init__(self, device: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Open a port for this program alone.

        Raises:
            PortError: the port cannot be opened; the message says why, and the cure.
        """
        self.device = device
        self._clock = clock
        self._waiting = bytearray()
        self._moved = clock()
        try:
            self._wire = SystemWire(device)
        except PortNotOpenedError as error:
            raise PortError(str(error)) from error

    def put(self, data: bytes) -> None:
        """Queue bytes to be sent when the port takes them; never blocks."""
        if not self._waiting:
            self._moved = self._clock()
        self._waiting += data

    def exchange(self, seconds: float) -> bytes:
        """Send waiting bytes and receive; return as soon as bytes came, or after a time [s].

        Raises:
            PortError: the port is gone, or takes no bytes any more.
        """
        try:
            if self._waiting:
                self._write()  # usually there is room, and no need to wait for it
            data = self._wire.read(seconds, sending=bool(self._waiting))
        except OSError as error:
            raise self._gone(error) from error
        if self._waiting and self._clock() - self._moved > STUCK_S:
            raise PortError(
                f"{self.device} accepts no data; has the device or program behind it stopped?"
            )
        return data

    def finish(self, last: bytes, seconds: float) -> bool:
        """Drop waiting bytes and send the last ones; return whether these left in time.

        Raises:
            PortError: the port is gone.
        """
        # A dropped line may be half sent: CR ends it, so that the last bytes begin a new line.
        self._waiting = bytearray(b"\r" + last if self._waiting else last)
        end = self._clock() + seconds
        while self._waiting and self._clock() < end:
            self.exchange(min(end - self._clock(), 0.01))
        while not self._waiting and self._clock() < end:
            try:
                if not self._wire.unsent():
                    return True
            except OSError as error:
                raise self._gone(error) from error
            time.sleep(0.001)
        return False

    def close(self) -> None:
        """Close the port; may be called twice."""
        self._wire.close()

    def _write(self) -> None:
        written = self._wire.write(self._waiting)
        if written:
            del self._waiting[:written]
            self._moved = self._clock()

    def _gone(self, error: OSError) -> PortError:
        if not error.strerror:
            return PortError(f"{self.device} is gone")
        return PortError(f"{self.device} is gone: {error.strerror}")


def stop_motors(device: str) -> None:
    """Tell all four ports to brake.

    Use it when a program ended without stopping the motors. If it was this program, the pulses in
    the firmware have ended by then. Motors started by another program keep turning.

    Raises:
        PortError: the port cannot be opened, or takes no bytes; the message says why, and the
            cure.
    """
    port = SerialPort(device)
    try:
        # A killed program may have left half a line: CR ends it, so that the stop is a line of its
        # own. Sent twice: if a byte of the first is lost, a motor can stay at the old set-point.
        if not port.finish(b"\r" + 2 * commands.stop(), PATIENCE_S):
            raise PortError(
                f"{device} accepts no data; has the device or program behind it stopped?"
            )
    finally:
        port.close()
