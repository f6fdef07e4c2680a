"""The emulator's camera: pictures from a Unix socket, each with the stamp of its exposure.

A picture is a header in the format ``HEADER`` (mark, stamp [s] by CLOCK_MONOTONIC, height, width,
channels), followed by its bytes, row by row.
"""

from __future__ import annotations

import socket
import struct
from pathlib import Path

import numpy as np

from robot.camera import Lens
from robot.cameras.camera import PictureError, check_size, upright
from robot.interface import Frame

HEADER = struct.Struct("<4sdIII")
MARK = b"BPF1"

LONGEST_READ = 1 << 20
"""Largest number of bytes in one read."""


class PictureSocket:
    """A client of the emulator's picture server."""

    def __init__(self, path: Path, lens: Lens, rotation: int = 0) -> None:
        """``path`` is the socket, ``rotation`` 0 or 180 [deg]."""
        self.name = f"the emulator's camera at {path}"
        self._path = path
        self._lens = lens
        self._rotation = rotation
        self._socket: socket.socket | None = None
        self._received = bytearray()

    def open(self) -> None:
        """Connect.

        Raises:
            PictureError: nothing listens at the socket.
        """
        self._received.clear()
        if not hasattr(socket, "AF_UNIX"):
            raise PictureError(f"{self.name} needs a socket of Linux or macOS, also in WSL")
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._socket.settimeout(1.0)
        try:
            self._socket.connect(str(self._path))
        except OSError as error:
            raise PictureError(
                f"{self.name} does not answer ({error.strerror or error}): start brickpose "
                f"emulate-hat --pictures {self._path}"
            ) from error

    def grab(self, timeout: float) -> Frame | None:
        """Wait for the next picture; None if no bytes come for ``timeout`` [s] before it is whole.

        Raises:
            PictureError: the emulator ended, or sends something else than its pictures.
        """
        if self._socket is None:
            raise PictureError(f"{self.name} is not open")
        self._socket.settimeout(timeout)
        try:
            while (frame := self._whole_picture()) is None:
                self._receive(self._socket)
        except TimeoutError:
            return None
        return frame

    def close(self) -> None:
        """Disconnect."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _receive(self, source: socket.socket) -> None:
        try:
            received = source.recv(LONGEST_READ)
        except TimeoutError:
            raise
        except OSError as error:
            raise PictureError(f"{self.name} was lost: {error.strerror or error}") from error
        if not received:
            raise PictureError(f"{self.name} has ended; start brickpose emulate-hat again")
        self._received += received

    def _whole_picture(self) -> Frame | None:
        """Remove the first received picture from the buffer; None while it is incomplete."""
        if len(self._received) < HEADER.size:
            return None
        stamp, shape = self._header()
        end = HEADER.size + int(np.prod(shape))
        if len(self._received) < end:
            return None
        pixels = np.frombuffer(bytes(self._received[HEADER.size : end]), dtype=np.uint8)
        del self._received[:end]
        return Frame(stamp, upright(pixels.reshape(shape), self._rotation))

    def _header(self) -> tuple[float, tuple[int, ...]]:
        mark, stamp, height, width, channels = HEADER.unpack_from(self._received)
        if mark != MARK or channels not in (1, 3) or not np.isfinite(stamp):
            raise PictureError(f"{self.name} sends no pictures of BrickPose's emulator")
        # The check precedes the wait for the bytes: a wrong size is reported at once, not buffered.
        check_size((height, width), self._lens, self.name)
        return stamp, (height, width) if channels == 1 else (height, width, channels)
