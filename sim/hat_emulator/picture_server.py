"""Serves pictures of the robot's camera to other programs, on a Unix socket.

The format of a picture on the wire is that of ``robot.cameras.picture_socket``.
"""

from __future__ import annotations

import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from robot.cameras.picture_socket import HEADER, MARK
from robot.errors import BrickPoseError
from robot.geometry import Pose2, Twist2
from robot.worker_thread import WorkerThread
from sim.floor_camera import FloorCamera
from sim.hat_emulator.pseudo_terminal import listen, stop_listening

JOIN_TIMEOUT = 5.0
"""How long the thread may take to end [s]."""

ROOM = 1 << 20
"""Size of the system's send buffer for a reader [bytes]: more than a picture."""


class PictureServerError(BrickPoseError, RuntimeError):
    """The server's thread has failed, or does not end."""


@dataclass(frozen=True, slots=True)
class Shot:
    """A picture that was exposed and is not yet computed."""

    stamp: float
    """Stamp of the picture [s], by CLOCK_MONOTONIC."""
    due: float
    """Time at which it is in memory [s], by CLOCK_MONOTONIC."""
    pose: Pose2
    """True pose in the map at the middle of the exposure."""
    twist: Twist2


@dataclass(eq=False)
class _Reader:
    """A program that reads pictures."""

    socket: socket.socket
    number: int = 0
    """Number of the picture that was sent last."""
    left: memoryview = field(default=memoryview(b""))
    """The part of it that is not sent yet."""


class PictureServer:
    """Computes the newest shot and sends it to every reader that has read its last picture.

    A slow reader misses pictures but does not delay other readers. Without readers, no picture is
    computed.
    """

    def __init__(
        self, path: Path, camera: FloorCamera, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """Listen at ``path``; call ``start`` to serve.

        Raises:
            PortError: it cannot listen there.
        """
        self._listening = listen(path)
        self._camera = camera
        self._clock = clock
        self._bell, self._ear = socket.socketpair()
        self._bell.setblocking(False)
        self._ear.setblocking(False)
        self._selector = selectors.DefaultSelector()
        self._selector.register(self._listening, selectors.EVENT_READ)
        self._selector.register(self._ear, selectors.EVENT_READ)
        self._readers: list[_Reader] = []
        self._shots: deque[Shot] = deque(maxlen=1)
        self._pictures: deque[tuple[float, bytes]] = deque()
        """Due times and bytes of pictures that are computed but not due yet."""
        self._number = 0
        self._newest = memoryview(b"")
        self._thread = WorkerThread(
            "pictures",
            self._run,
            owner="the emulated camera",
            patience=JOIN_TIMEOUT,
            wake=self._ring,
        )

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def take(self, shot: Shot) -> None:
        """Send this picture when it is due, unless a newer one comes before it is computed.

        Raises:
            PictureServerError: serving has failed.
        """
        failure = self._thread.failure
        if failure is not None:
            raise PictureServerError(f"no more pictures: {failure}") from failure
        self._shots.append(shot)
        self._ring()

    def close(self) -> None:
        """Stop the server and remove the socket; may be called twice.

        Raises:
            PictureServerError: the thread does not end.
        """
        if self._thread.stopping.is_set():
            return
        if not self._thread.stop():
            raise PictureServerError(f"pictures did not end within {JOIN_TIMEOUT:g} s")
        for reader in self._readers:
            reader.socket.close()
        self._selector.close()
        self._bell.close()
        self._ear.close()
        stop_listening(self._listening)

    def _ring(self) -> None:
        with suppress(BlockingIOError):  # the thread is already notified
            self._bell.send(b"!")

    def _run(self, stopping: threading.Event) -> None:
        while not stopping.is_set():
            self._turn()

    def _turn(self) -> None:
        """Wait for something to do, and do it."""
        for key, _ in self._selector.select(self._until_due()):
            if key.fileobj is self._listening:
                self._welcome()
            elif key.fileobj is self._ear:
                self._ear.recv(1024)
            else:
                self._serve(key.data)
        if self._shots:
            self._expose(self._shots.pop())
        while self._pictures and self._until_due() == 0:
            self._send_out(self._pictures.popleft()[1])

    def _expose(self, shot: Shot) -> None:
        """Compute a picture, if there is a reader."""
        if self._readers:
            image = self._camera.picture(shot.pose, shot.twist)
            header = HEADER.pack(MARK, shot.stamp, *(*image.shape, 1)[:3])
            self._pictures.append((shot.due, header + image.tobytes()))

    def _until_due(self) -> float | None:
        return max(0.0, self._pictures[0][0] - self._clock()) if self._pictures else None

    def _send_out(self, picture: bytes) -> None:
        self._number += 1
        self._newest = memoryview(picture)
        for reader in list(self._readers):
            if not reader.left:
                self._serve(reader)

    def _welcome(self) -> None:
        with suppress(BlockingIOError):  # the reader has gone again
            connection, _ = self._listening.accept()
            connection.setblocking(False)
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, ROOM)
            # Send only pictures from now on.
            reader = _Reader(connection, self._number)
            self._readers.append(reader)
            self._selector.register(connection, selectors.EVENT_READ, reader)

    def _serve(self, reader: _Reader) -> None:
        """Send as much as there is room for; drop a reader that has gone."""
        try:
            if self._has_gone(reader):
                self._dismiss(reader)
                return
            if not reader.left and reader.number != self._number:
                reader.number, reader.left = self._number, self._newest
            if reader.left:
                reader.left = reader.left[reader.socket.send(reader.left) :]
        except BlockingIOError:
            pass
        except OSError:
            self._dismiss(reader)
            return
        more = reader.left or reader.number != self._number
        wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if more else 0)
        self._selector.modify(reader.socket, wanted, reader)

    def _has_gone(self, reader: _Reader) -> bool:
        try:
            return len(reader.socket.recv(1024)) == 0
        except BlockingIOError:
            return False

    def _dismiss(self, reader: _Reader) -> None:
        self._selector.unregister(reader.socket)
        self._readers.remove(reader)
        reader.socket.close()
