"""The listening socket of the program, which lets in as many clients as it has room for."""

from __future__ import annotations

import contextlib
import errno
import os
import socket
from contextlib import ExitStack
from typing import Any

from app.operating_system import claim_address, raise_descriptors
from app.page.room import MOST, Room
from robot.errors import PortError

SMALL_BUFFER = 16 * 1024
"""Size of a socket's buffer [bytes]: data in a larger one is old when a slow viewer gets it."""

BACKLOG = 64
"""Most connections that wait to be accepted; asyncio accepts as many at a time."""

OTHERS = 100
"""Descriptors for all else: files, camera, serial port, and connections that are just ending."""
FEWEST = 16

USED_UP = (errno.EMFILE, errno.ENFILE)


def listen(host: str, port: int) -> Listening:
    """Return a listening socket.

    Raises:
        PortError: the address is not of this machine, or the port is taken or not allowed.
    """
    try:
        result = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, proto=socket.IPPROTO_TCP)
        family, kind, protocol, _, address = result[0]
        with ExitStack() as unless_it_listens:
            # asyncio sends each part at once only if the protocol is given. Otherwise the second
            # part of an answer waits until the first is acknowledged: 40 ms.
            listening = Listening(family, kind, protocol)
            unless_it_listens.callback(listening.close)
            claim_address(listening)
            listening.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SMALL_BUFFER)
            listening.bind(address)
            listening.listen(BACKLOG)
            unless_it_listens.pop_all()
    except (OSError, UnicodeError) as error:  # UnicodeError: no name of a machine is like this
        why = getattr(error, "strerror", None) or error
        taken = getattr(error, "errno", None) in (errno.EADDRINUSE, errno.EACCES)
        cure = (
            "another port is chosen by --port (or PORT=9000 make run)"
            if taken
            else "valid is an address of this machine, or 0.0.0.0 for all of them"
        )
        raise PortError(f"cannot listen on {host} port {port}: {why}; {cure}") from error
    return listening


def most_places() -> int:
    """Return how many connections there is room for, as the system allows descriptors."""
    return max(FEWEST, min(MOST, raise_descriptors() - OTHERS))


class Listening(socket.socket):
    """A listening socket that never fails to accept: without room, it drops the connection.

    Where descriptors are used up, asyncio would log thousands of failures a second, and do nothing
    else meanwhile: a connection that waits is offered to it again at once.
    """

    def __init__(self, *arguments: int) -> None:
        super().__init__(*arguments)
        self.room = Room(most_places())
        self._spare = os.open(os.devnull, os.O_RDONLY)

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection that there is room for.

        Raises:
            BlockingIOError: there is none.
        """
        try:
            connection, address = super().accept()
        except OSError as error:
            if error.errno in USED_UP:
                self._drop_waiting()
                raise BlockingIOError(error.errno, "descriptors are used up") from error
            raise
        if not self.room.admit(connection, address[0]):
            connection.close()
            raise BlockingIOError(errno.EAGAIN, "there is no room")
        return connection, address

    def close(self) -> None:
        """Close the socket; may be called twice."""
        self._close_spare()
        super().close()

    def _drop_waiting(self) -> None:
        """Drop a connection that waits, with a descriptor that is kept for this."""
        self.room.release()
        self._close_spare()
        with contextlib.suppress(OSError):
            super().accept()[0].close()
        # Another thread may have taken the descriptor: then there is none to keep until next time.
        with contextlib.suppress(OSError):
            self._spare = os.open(os.devnull, os.O_RDONLY)

    def _close_spare(self) -> None:
        spare, self._spare = self._spare, -1
        if spare >= 0:
            os.close(spare)
