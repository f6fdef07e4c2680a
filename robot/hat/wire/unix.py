"""A serial port of Linux or macOS: its descriptor is waited for."""

from __future__ import annotations

import errno
import fcntl
import os
import select
import sys
import termios

import serial  # type: ignore[import-untyped, unused-ignore]

from robot.hat.wire.ports import other_ports
from robot.hat.wire.wire import BAUD, TOGETHER_S, PortNotOpenedError

PTY_MAJORS = range(136, 144)
CHUNK = 4096
"""Most bytes in one read."""

RASPI_CONFIG = "sudo raspi-config, Interface Options, Serial Port: login shell no, hardware yes"


class UnixWire:
    """An open port; nothing of it ever waits, but ``read`` for as long as it is told."""

    def __init__(self, device: str) -> None:
        """Open a port for this program alone.

        Raises:
            PortNotOpenedError: it cannot be opened.
        """
        self._port = serial.Serial(None, BAUD, timeout=0, write_timeout=0, exclusive=True)
        self._port.port = device
        try:
            self._port.open()
            self._fd: int = self._port.fileno()
            _refuse_others(self._fd)
        except (OSError, ValueError) as error:
            self._port.close()
            raise PortNotOpenedError(_reason(device, error)) from error

    def read(self, seconds: float, *, sending: bool) -> bytes:
        """Return what came; wait for it, at most for a time [s]."""
        writing = [self._fd] if sending else []
        readable, _, _ = select.select([self._fd], writing, [], max(0.0, seconds))
        if not readable:
            return b""
        select.select([], [], [], TOGETHER_S)
        try:
            data = os.read(self._fd, CHUNK)
        except BlockingIOError:
            return b""
        if not data:
            raise OSError(errno.ENODEV, "")
        return data

    def write(self, data: bytes | bytearray) -> int:
        """Send as much as there is room for, without waiting; return how many bytes."""
        # pyserial's own write spins while a port is full.
        try:
            return os.write(self._fd, data)
        except BlockingIOError:
            return 0

    def unsent(self) -> int:
        """Return how many written bytes have not left yet."""
        return int(self._port.out_waiting)

    def close(self) -> None:
        """Close the port; may be called twice."""
        self._port.close()


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
            if sys.platform != "linux":
                return f"there is no serial port {device}; {other_ports('/dev/cu.usbserial-1')}"
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
