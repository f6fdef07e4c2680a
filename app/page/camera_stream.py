"""Camera pictures for people: one JPEG, a stream of JPEGs, and a stream of JPEGs with stamps."""

from __future__ import annotations

import struct
import threading
from collections.abc import AsyncIterator

import anyio
import anyio.to_thread
import cv2
from starlette.responses import Response, StreamingResponse
from starlette.websockets import WebSocket, WebSocketDisconnect

from app.engine.mailboxes.latest import Latest
from app.engine.snapshot import Snapshot
from robot.interface import Frame

QUALITY = 75
BOUNDARY = "frame"
LONGEST_WAIT_S = 0.2
"""Longest time between two checks whether the program ends [s]."""


class CameraStream:
    """Encodes each picture once for all viewers."""

    def __init__(self, latest: Latest[Snapshot], stopping: threading.Event) -> None:
        self._latest = latest
        self._stopping = stopping
        self._encoded: tuple[Frame, bytes] | None = None
        self._lock = anyio.Lock()

    async def jpeg(self, frame: Frame) -> bytes:
        """Return the picture as JPEG."""
        async with self._lock:
            if self._encoded is None or self._encoded[0] is not frame:
                data = await anyio.to_thread.run_sync(_encode, frame)
                self._encoded = (frame, data)
            return self._encoded[1]

    async def picture(self) -> Response:
        """Return the newest picture, or status 503 before the first."""
        latest = self._latest.get()
        if latest is None or latest.frame is None:
            return Response("The camera has sent no picture yet.", status_code=503)
        data = await self.jpeg(latest.frame)
        return Response(data, media_type="image/jpeg", headers={"Cache-Control": "no-store"})

    def motion_jpeg(self) -> Response:
        """Return a stream of pictures in the form that browsers show in an ``<img>``."""
        return StreamingResponse(
            self._parts(),
            media_type=f"multipart/x-mixed-replace; boundary={BOUNDARY}",
            headers={"Cache-Control": "no-store"},
        )

    async def serve(self, socket: WebSocket) -> None:
        """Send each newest picture: 8 bytes of stamp (little-endian float64 [s]) and a JPEG."""
        await socket.accept()
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._send, socket)
            await _until_gone(socket)
            tasks.cancel_scope.cancel()

    async def _send(self, socket: WebSocket) -> None:
        try:
            async for frame in self._frames():
                await socket.send_bytes(struct.pack("<d", frame.stamp) + await self.jpeg(frame))
        except (WebSocketDisconnect, RuntimeError):
            # The viewer left between two pictures; starlette raises a RuntimeError after the close.
            return

    async def _frames(self) -> AsyncIterator[Frame]:
        with self._latest.subscribe() as subscription:
            shown = None
            while not self._stopping.is_set():
                frame = None
                # The wait is limited: a waiting stream would delay the end of the program.
                with anyio.move_on_after(LONGEST_WAIT_S):
                    frame = (await subscription.next()).frame
                if frame is not None and frame is not shown:
                    shown = frame
                    yield frame

    async def _parts(self) -> AsyncIterator[bytes]:
        async for frame in self._frames():
            data = await self.jpeg(frame)
            head = (
                f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(data)}\r\n\r\n"
            )
            yield head.encode() + data + b"\r\n"


async def _until_gone(socket: WebSocket) -> None:
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass


def _encode(frame: Frame) -> bytes:
    _, data = cv2.imencode(".jpg", frame.image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return data.tobytes()
