"""Camera pictures for people: one JPEG, a stream of JPEGs, and pictures with their scans."""

from __future__ import annotations

import struct
import threading
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

import anyio
import anyio.to_thread
import cv2
from starlette.exceptions import HTTPException
from starlette.responses import Response, StreamingResponse
from starlette.websockets import WebSocket

from app.engine.mailboxes.latest import Latest
from app.engine.mailboxes.websocket_writer import WebsocketWriter
from app.engine.rest import Audience
from app.engine.snapshot import Snapshot
from app.messages.telemetry import EdgesMessage, PictureMessage
from app.page.telemetry import tape_width
from robot.interface import Frame
from robot.scanning.line_scanner import LineScan, LineScanner
from robot.scanning.tape_edges import Verdict

QUALITY = 75
BOUNDARY = "frame"
STREAM = "multipart/x-mixed-replace"
PICTURES_ONLY = 1.0
"""Ticks a second that a stream needs besides those with a new picture."""
LONGEST_WAIT_S = 0.2
"""Longest time between two checks whether the program ends [s]."""


@dataclass(frozen=True, slots=True)
class _Picture:
    """An encoded picture."""

    frame: Frame
    jpeg: bytes = field(repr=False)
    message: bytes = field(repr=False)
    """The message of ``/api/camera``, as ``PictureMessage`` describes it."""


class CameraStream:
    """Encodes each picture once for all viewers."""

    def __init__(
        self, latest: Latest[Snapshot], stopping: threading.Event, audience: Audience
    ) -> None:
        self._latest = latest
        self._audience = audience
        self._stopping = stopping
        self._encoded: _Picture | None = None
        self._lock = anyio.Lock()

    async def picture(self) -> Response:
        """Return the newest picture, or status 503 before the first."""
        self._audience.visit()
        latest = self._latest.get()
        if latest is None or latest.frame is None:
            raise HTTPException(503, "The camera has sent no picture yet.")
        data = (await self._encode(latest, latest.frame)).jpeg
        return Response(data, media_type="image/jpeg", headers={"Cache-Control": "no-store"})

    def motion_jpeg(self) -> Response:
        """Return a stream of pictures in the form that browsers show in an ``<img>``."""
        return StreamingResponse(
            self._parts(),
            media_type=f"{STREAM}; boundary={BOUNDARY}",
            headers={"Cache-Control": "no-store"},
        )

    async def serve(self, socket: WebSocket) -> None:
        """Send each newest picture with its scan as soon as the last one is sent."""
        await socket.accept()
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._send, WebsocketWriter(socket))
            await _until_gone(socket)
            tasks.cancel_scope.cancel()

    async def _send(self, outgoing: WebsocketWriter) -> None:
        async for picture in self._pictures():
            if not await outgoing.send(picture.message):
                return

    async def _pictures(self) -> AsyncIterator[_Picture]:
        with self._audience.joined(PICTURES_ONLY), self._latest.subscribe() as subscription:
            shown: Frame | None = None
            while not self._stopping.is_set():
                newest: Snapshot | None = None
                # The wait is limited: a waiting stream would delay the end of the program.
                with anyio.move_on_after(LONGEST_WAIT_S):
                    while newest is None or newest.frame is None or newest.frame is shown:
                        newest = await subscription.next()
                if newest is None or newest.frame is None or newest.frame is shown:
                    continue
                shown = newest.frame
                yield await self._encode(newest, newest.frame)

    async def _parts(self) -> AsyncIterator[bytes]:
        async for picture in self._pictures():
            head = (
                f"--{BOUNDARY}\r\nContent-Type: image/jpeg\r\n"
                f"Content-Length: {len(picture.jpeg)}\r\n\r\n"
            )
            yield head.encode() + picture.jpeg + b"\r\n"

    async def _encode(self, snapshot: Snapshot, frame: Frame) -> _Picture:
        if self._encoded is None or self._encoded.frame is not frame:
            async with self._lock:
                if self._encoded is None or self._encoded.frame is not frame:
                    self._encoded = await anyio.to_thread.run_sync(encoded, snapshot, frame)
        return self._encoded


async def _until_gone(socket: WebSocket) -> None:
    while (await socket.receive())["type"] != "websocket.disconnect":
        pass


def encoded(snapshot: Snapshot, frame: Frame) -> _Picture:
    """Return a picture as JPEG, with the edges on it that were scanned."""
    edges, line_scan, scanner = None, snapshot.filter.line_scan, snapshot.filter.scanner
    # A picture that came too late was not scanned: the newest scan is that of an older picture.
    if line_scan is not None and scanner is not None and line_scan.scan.stamp == frame.stamp:
        edges = _edges_message(line_scan, scanner)
    head = PictureMessage(stamp=frame.stamp, edges=edges).model_dump_json().encode()
    _, data = cv2.imencode(".jpg", frame.image, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    jpeg = data.tobytes()
    return _Picture(frame, jpeg, struct.pack("<I", len(head)) + head + jpeg)


def _edges_message(line_scan: LineScan, scanner: LineScanner) -> EdgesMessage:
    """Return where the rays of a scan enter and leave the tape in the picture."""
    counted = (line_scan.verdicts == Verdict.COUNTED).tolist()
    entry_px, exit_px = (
        [
            (u, v) if shown else None
            for (u, v), shown in zip(pixels.round(1).tolist(), counted, strict=True)
        ]
        for pixels in map(scanner.pixels, line_scan.edges.T)
    )
    return EdgesMessage(entry_px=entry_px, exit_px=exit_px, tape_width=tape_width(line_scan))
