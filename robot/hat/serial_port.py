"""The serial port that a Build HAT is on; and how the motors are stopped that nobody drives."""

from __future__ import annotations

import errno
import fcntl
import os
import re
import select
import termios
import time
from collections.abc import Callable
from pathlib import Path

import serial  # type: ignore[import-untyped, unused-ignore]

from robot.errors import PortError
from robot.hat.protocol import commands

BAUD = 115_200
TOGETHER_S = 0.003
"""How long to wait for the rest of a line [s]; a line of 21 bytes takes 2 ms to arrive. Waking up
for each part of it would double the processor load."""

STUCK_S = 3.0
"""A port that takes no byte for this time is given up [s]."""

MODEL = Path("/proc/device-tree/model")
RP1_MODELS = re.compile(r"Raspberry Pi (?:5|500|Compute Module 5)\b")
PTY_MAJORS = range(136, 144)

RASPI_CONFIG = "sudo raspi-config, Interface Options, Serial Port: login shell no, hardware yes"


def find_device(model: Path = MODEL) -> str:
    """Return the serial port on this Pi's header; on a Pi 5 /dev/serial0 is another connector."""
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
        self._port = serial.Serial(None, BAUD, timeout=0, write_timeout=0, exclusive=True)
        self._port.port = device
        try:
            self._port.open()
            self._fd: int = self._port.fileno()
            _refuse_others(self._fd)
        except (OSError, ValueError) as error:
            self._port.close()
            raise PortError(_reason(device, error)) from error

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
            writing = [self._fd] if self._waiting else []
            readable, _, _ = select.select([self._fd], writing, [], max(0.0, seconds))
            if readable:
                select.select([], [], [], TOGETHER_S)
            data = os.read(self._fd, 4096) if readable else b""
        except BlockingIOError:
            return b""
        except OSError as error:
            raise PortError(f"{self.device} is gone: {error.strerror}") from error
        if readable and not data:
            raise PortError(f"{self.device} is gone")
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
                if not self._port.out_waiting:
                    return True
            except OSError as error:
                raise PortError(f"{self.device} is gone: {error.strerror}") from error
            select.select([], [], [], 0.001)
        return False

    def close(self) -> None:
        """Close the port; may be called twice."""
        self._port.close()

    def _write(self) -> None:
        # pyserial's own write spins while a port is full.
        try:
            written = os.write(self._fd, self._waiting)
        except BlockingIOError:
            return
        if written:
            del self._waiting[:written]
            self._moved = self._clock()


def _refuse_others(fd: int) -> None:
    """Let no other program open the port, not even one that ignores locks.

    A pseudo-terminal is excepted: its other end outlives a killed program, and the refusal with it.
    """
    if os.major(os.fstat(fd).st_rdev) not in PTY_MAJORS:
        fcntl.ioctl(fd, termios.TIOCEXCL)


def _reason(device: str, error: OSError | ValueError) -> str:
    """Return why a port cannot be opened, and what to do."""
    match error.errno if isinstance(error, OSError) else None:
        case errno.ENOENT | errno.ENXIO | errno.ENODEV:
            return f"there is no serial port {device}; switch it on: {RASPI_CONFIG}; then reboot"
        case errno.EACCES | errno.EPERM:
            return (
                f"no permission to open {device}; take it: sudo usermod -aG dialout $USER; "
                "then log in again"
            )
        case errno.EBUSY | errno.EAGAIN:
            return (
                f"another program has {device} open; end it, or if it is the login shell: "
                f"{RASPI_CONFIG}; then reboot"
            )
    return f"{device} cannot be opened as a serial port: {error}"


PATIENCE_S = 1.0
"""Longest time for sending the stop [s]; a line of 63 bytes takes 5 ms."""


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
