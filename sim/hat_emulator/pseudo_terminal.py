"""A pseudo-terminal: a serial port without a wire, opened as a device; and Unix sockets."""

from __future__ import annotations

import os
import socket
import tty
from contextlib import suppress
from pathlib import Path

from robot.errors import PortError

CHUNK = 4096
"""Most bytes in one read."""


class PseudoTerminal:
    """Our end of a pseudo-terminal; it never waits.

    Bytes that nobody reads are dropped, as a board with a full buffer does. The terminal is raw
    from the start: an echo or a converted line end would garble the commands. The device also
    stays open here; otherwise our end would fail between two programs.
    """

    def __init__(self, link: Path | None = None) -> None:
        """Create it, and a symbolic link to the device if a name is given.

        Raises:
            PortError: the name is in use and is not a link, or its folder does not exist.
        """
        self._end: int | None
        self._end, self._device = os.openpty()
        self._link: Path | None = None
        try:
            tty.setraw(self._device)
            os.set_blocking(self._end, False)
            self.device = os.ttyname(self._device)
            """Name of the device; programs open it as they would /dev/serial0."""
            if link is not None:
                self._make_link(link)
        except BaseException:
            self.close()
            raise

    @property
    def name(self) -> str:
        """Path to open: the link if there is one, else the device."""
        return self.device if self._link is None else str(self._link)

    def fileno(self) -> int:
        """Return the descriptor of our end, for ``select``.

        Raises:
            PortError: it is closed.
        """
        if self._end is None:
            raise PortError("the serial port is closed")
        return self._end

    def read(self) -> bytes:
        """Return what a program has written since the last read; empty if nothing."""
        with suppress(BlockingIOError):
            return os.read(self.fileno(), CHUNK)
        return b""

    def write(self, data: bytes) -> int:
        """Write bytes for a reader; return how many there was room for."""
        if not data:
            return 0
        with suppress(BlockingIOError):
            return os.write(self.fileno(), data)
        return 0

    def close(self) -> None:
        """Close the port and remove its link; may be called twice."""
        if self._end is None:
            return
        self._drop_link()
        os.close(self._end)
        os.close(self._device)
        self._end = None

    def _make_link(self, link: Path) -> None:
        try:
            if link.is_symlink():
                link.unlink()
            link.symlink_to(self.device)
        except FileExistsError as error:
            raise PortError(f"{link} is there and no link: it stays as it is") from error
        except OSError as error:
            raise PortError(f"no link {link} can be made: {error.strerror}") from error
        self._link = link

    def _drop_link(self) -> None:
        """Remove the link if it is ours: another program may have put its own there since."""
        link = self._link
        if link is not None and link.is_symlink() and str(link.readlink()) == self.device:
            link.unlink()
        self._link = None


def listen(path: Path) -> socket.socket:
    """Open a non-blocking stream socket; a socket that a killed program left there is replaced.

    Raises:
        PortError: another program listens there, a file is there, or there is no such folder.
    """
    listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_NONBLOCK)
    try:
        if path.is_socket():
            _check_deserted(path)
            path.unlink()
        listening.bind(str(path))
        listening.listen()
    except OSError as error:
        listening.close()
        if isinstance(error, PortError):
            raise
        raise PortError(f"nothing can listen at {path}: {error.strerror or error}") from error
    return listening


def stop_listening(listening: socket.socket) -> None:
    """Close a socket of ``listen`` and remove its file."""
    path = Path(listening.getsockname())
    listening.close()
    with suppress(FileNotFoundError):
        path.unlink()


def _check_deserted(path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as trial:
        try:
            trial.connect(str(path))
        except ConnectionRefusedError:
            return
        raise PortError(f"another program listens at {path}")
