"""``/api/recordings``: lists recordings and serves their files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from fastapi import APIRouter, HTTPException, Response
from fastapi.responses import FileResponse, StreamingResponse

from app.messages.message import Message
from app.recordings.files.recorded import RecordingError
from app.recordings.listing import Listed, find, listed

MEDIA_TYPE = "application/octet-stream"
BLOCK = 1 << 20
"""Block size for reading a file that is still being written [bytes]."""


class RecordingEntry(Message):
    """One recording."""

    name: str
    """``/api/recordings/NAME`` serves the file."""
    size_bytes: int
    duration_s: float | None
    """Null if it is unknown."""
    unfinished: bool
    """Still being recorded, or cut off by a full disk or the end of the program; it can be read."""


def recordings_router(folder: Callable[[], Path]) -> APIRouter:
    """List and serve the recordings of a folder; ``folder`` is called at each request."""
    router = APIRouter()

    @router.get("/api/recordings")
    def recordings() -> list[RecordingEntry]:
        """All recordings, newest first."""
        return [
            RecordingEntry(
                name=item.name,
                size_bytes=item.size_bytes,
                duration_s=item.duration_s,
                unfinished=item.unfinished,
            )
            for item in listed(folder())
        ]

    @router.get("/api/recordings/{name}", response_class=Response)
    def recording(name: str) -> Response:
        """A recording as one MCAP file; of an unfinished one, what is written so far."""
        try:
            result = find(folder(), name)
        except RecordingError as error:
            raise HTTPException(404, str(error)) from error
        if result.unfinished:
            return _so_far(result)
        return FileResponse(result.file, media_type=MEDIA_TYPE, filename=f"{name}.mcap")

    return router


def _so_far(result: Listed) -> Response:
    """Send what is written so far: the announced length must not change meanwhile."""
    headers = {
        "Content-Length": str(result.size_bytes),
        "Content-Disposition": f'attachment; filename="{result.name}.mcap"',
    }
    return StreamingResponse(_blocks(result), media_type=MEDIA_TYPE, headers=headers)


def _blocks(result: Listed) -> Iterator[bytes]:
    left = result.size_bytes
    with result.file.open("rb") as file:
        while left and (block := file.read(min(left, BLOCK))):
            left -= len(block)
            yield block
