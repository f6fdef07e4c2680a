"""A wire between a browser and a server that a test can hold up, or cut."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from serving import ServedProgram


class BreakableWire:
    """Passes connections of a port of its own on to a server."""

    def __init__(self, target: str) -> None:
        host, _, port = target.partition(":")
        self._target = host, int(port)
        self._door = socket.create_server((host, 0))
        self.address = f"{host}:{self._door.getsockname()[1]}"
        self._ends: list[socket.socket] = []
        self._whole = True
        self._flows = threading.Event()
        self._flows.set()
        threading.Thread(target=self._serve, daemon=True).start()

    def hold_up(self) -> None:
        """Pass nothing on, and keep what comes, as a radio that hears nothing does."""
        self._flows.clear()

    def cut(self) -> None:
        """Break all connections, and take no new ones."""
        self._whole = False
        self._close_ends()

    def mend(self) -> None:
        """Be as before."""
        self._whole = True
        self._flows.set()

    def close(self) -> None:
        self.mend()
        self._door.close()
        self._close_ends()

    def _close_ends(self) -> None:
        ends, self._ends = self._ends, []
        for end in ends:
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
            end.close()

    def _serve(self) -> None:
        with suppress(OSError):  # the door is closed
            while True:
                near, _ = self._door.accept()
                if not self._whole:
                    near.close()
                    continue
                far = socket.create_connection(self._target)
                self._ends += [near, far]
                for pair in ((near, far), (far, near)):
                    threading.Thread(target=self._pass_on, args=pair, daemon=True).start()

    def _pass_on(self, giver: socket.socket, taker: socket.socket) -> None:
        with suppress(OSError):
            while data := giver.recv(65536):
                self._flows.wait()
                taker.sendall(data)
        for end in (giver, taker):
            with suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)


@contextmanager
def breakable(server: ServedProgram) -> Iterator[tuple[BreakableWire, ServedProgram]]:
    """A wire, and the server at its near end."""
    wire = BreakableWire(server.address)
    try:
        yield wire, ServedProgram(server.process, wire.address)
    finally:
        wire.close()
