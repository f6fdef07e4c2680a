"""Unix sockets that the emulator listens on."""

from __future__ import annotations

import socket
from contextlib import suppress
from pathlib import Path

from robot.errors import PortError


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
