"""The serial port of a Build HAT: which it is, how it is opened, and bytes without blocking."""

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

BAUD = 115_200
TOGETHER_S = 0.003
"""A line of 21 bytes takes 2 ms to arrive; all of it is waited for [s]. To be woken for each of its
parts would take as much of the processor again."""

STUCK_S = 3.0
"""A port that takes no byte for so long is given up."""

MODEL = Path("/proc/device-tree/model")
RP1_MODELS = re.compile(r"Raspberry Pi (?:5|500|Compute Module 5)\b")
PTY_MAJORS = range(136, 144)

RASPI_CONFIG = "sudo raspi-config, Interface Options, Serial Port: login shell no, hardware yes"


class PortError(OSError):
    """A serial port cannot be opened or used; says what to do."""


def find_device(model: Path = MODEL) -> str:
    """The serial port on this Pi's header; on a Pi 5 /dev/serial0 is another connector."""
    try:
        name = model.read_text(encoding="utf-8", errors="replace")
    except OSError:
        # Not a Raspberry Pi: opening the port will say so.
        name = ""
    return "/dev/ttyAMA0" if RP1_MODELS.search(name) else "/dev/serial0"


class SerialPort:
    """An open port; whatever is written waits here until the port takes it."""

    def __init__(self, device: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Open a port for this program alone.

        Raises:
            PortError: it cannot be; says why, and the cure.
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
        """Send when the port takes it; never blocks."""
        if not self._waiting:
            self._moved = self._clock()
        self._waiting += data

    def exchange(self, seconds: float) -> bytes:
        """Send what waits and receive; returns as soon as something came, or after a time [s].

        Raises:
            PortError: the port is gone, or takes nothing any more.
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
            raise PortError(f"{self.device} takes no bytes; is what is behind it stopped?")
        return data

    def finish(self, last: bytes, seconds: float) -> bool:
        """Drop what waits, send last words and let them leave; whether they left in time.

        Raises:
            PortError: the port is gone.
        """
        # A line may be cut in the middle: its end keeps the last words from being glued to it.
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
        """Let go of the port; may be called twice."""
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
    """Let nobody else open the port, not even who knows nothing of locks.

    Not for a pseudo-terminal: its other end outlives a killed program, and the refusal with it.
    """
    if os.major(os.fstat(fd).st_rdev) not in PTY_MAJORS:
        fcntl.ioctl(fd, termios.TIOCEXCL)


def _reason(device: str, error: OSError | ValueError) -> str:
    """Why a port cannot be opened, and what to do."""
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
