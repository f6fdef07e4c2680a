"""Lists recordings and serves their files; serves what a recording made elsewhere needs."""

from __future__ import annotations

import base64
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import BinaryIO

from fastapi import APIRouter, HTTPException, Request, Response
from fastapi.responses import FileResponse, StreamingResponse
from starlette.concurrency import run_in_threadpool

from app.features.recordings.attachments import Attachment, Contents
from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.library import (
    UPLOADS,
    Listed,
    add,
    annotate,
    delete,
    find,
    listed,
    picture_in,
    remove_left,
    rename,
)
from app.features.recordings.messages import ChangeMessage, RecordingEntry
from app.messages.answers import content, refusal
from app.messages.message import Message
from robot.errors import BrickPoseError

MEDIA_TYPE = "application/octet-stream"
FILE = content(MEDIA_TYPE) | refusal(404, "no such recording")
PICTURE = content("image/jpeg") | refusal(404, "no such recording, or no picture in it")
PICTURE_KEPT = "private, max-age=86400"
"""The page asks for the picture with the time at which the recording was written."""
CHANGE = refusal(409, "no such recording, a name that is taken, or a file that is none")
BLOCK = 1 << 20
"""Block size for reading a file that is still being written [bytes]."""
KEPT_FREE = 64 << 20
"""Uploads leave this much of the disk [bytes] to a running recording, the pose file and maps."""


def recordings_router(folder: Callable[[], Path], opened: Path | None = None) -> APIRouter:
    """List, serve and change the recordings of a folder.

    Args:
        folder: returns the folder; called at each request.
        opened: file or folder of the recording that this program replays, which must stay.
    """
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
                changed=item.changed,
                notes=item.notes,
            )
            for item in listed(folder())
        ]

    @router.get("/api/recordings/{name}", response_class=Response, responses=FILE)
    def recording(name: str) -> Response:
        """A recording as one MCAP file; of an unfinished one, what is written so far."""
        try:
            result = find(folder(), name)
        except RecordingError as error:
            raise HTTPException(404, str(error)) from error
        if result.unfinished:
            return _so_far(result)
        return FileResponse(result.file, media_type=MEDIA_TYPE, filename=f"{name}.mcap")

    _add_changes(router, folder, opened)
    return router


def _add_changes(router: APIRouter, folder: Callable[[], Path], opened: Path | None) -> None:
    @router.get("/api/recordings/{name}/picture", response_class=Response, responses=PICTURE)
    def picture(name: str) -> Response:
        """A picture that the robot saw in the middle of the recording."""
        with _refused(404):
            jpeg = picture_in(find(folder(), name))
        if jpeg is None:
            raise HTTPException(404, "the recording has no picture")
        return Response(jpeg, media_type="image/jpeg", headers={"Cache-Control": PICTURE_KEPT})

    @router.patch("/api/recordings/{name}", status_code=204, responses=CHANGE)
    def change(name: str, wanted: ChangeMessage) -> None:
        """Rename a recording, or write notes about it."""
        with _refused(409):
            if wanted.notes is not None:
                annotate(folder(), name, wanted.notes)
            if wanted.name is not None and wanted.name != name:
                _require_closed(folder(), name, opened)
                rename(folder(), name, wanted.name)

    @router.delete("/api/recordings/{name}", status_code=204, responses=CHANGE)
    def remove(name: str) -> None:
        """Delete a recording."""
        with _refused(409):
            _require_closed(folder(), name, opened)
            delete(folder(), name)

    @router.put("/api/recordings/{name}", status_code=204, responses=CHANGE)
    async def upload(name: str, request: Request) -> None:
        """Take a recording into the folder: the body is an MCAP file."""
        parent = folder()
        with _refused(409):
            try:
                parent.mkdir(parents=True, exist_ok=True)
                remove_left(parent)
                with TemporaryDirectory(dir=parent, prefix=UPLOADS) as made:
                    file = Path(made) / "new.mcap"
                    await _receive(request, file)
                    await run_in_threadpool(add, parent, name, file)
            except OSError as error:
                why = error.strerror or error
                raise RecordingError(f"nothing can be kept in {parent}: {why}") from error


def _require_closed(parent: Path, name: str, opened: Path | None) -> None:
    file = find(parent, name).file.resolve()
    # The command line opens files, and the page folders.
    if opened is not None and opened.resolve() in (file, file.parent):
        raise RecordingError(f"{name} is open; go back to the robot first")


async def _receive(request: Request, path: Path) -> None:
    with path.open("wb") as file:
        async for block in request.stream():
            # A slow disk must not hold up telemetry and commands.
            await run_in_threadpool(_write, file, block)


def _write(file: BinaryIO, block: bytes) -> None:
    if shutil.disk_usage(Path(file.name).parent).free < KEPT_FREE + len(block):
        raise RecordingError(
            f"the disk is full, but for {KEPT_FREE >> 20} MB that the program keeps for itself"
        )
    file.write(block)


@contextmanager
def _refused(status: int) -> Iterator[None]:
    try:
        yield
    except BrickPoseError as error:
        raise HTTPException(status, str(error)) from error


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


class AttachmentMessage(Message):
    """A file that goes into the recording."""

    name: str
    data: str
    """The content in base64."""


class ContentsMessage(Message):
    """Facts and files."""

    facts: dict[str, str]
    attachments: list[AttachmentMessage]

    def contents(self) -> Contents:
        """Decode the message.

        Raises:
            ValueError: a file is not valid base64.
        """
        files = tuple(
            Attachment(attachment.name, base64.b64decode(attachment.data, validate=True))
            for attachment in self.attachments
        )
        return Contents(self.facts, files)


def contents_router(contents: Callable[[], Contents]) -> APIRouter:
    """Serve a recording's facts and files, so that a recording made elsewhere can be replayed."""
    router = APIRouter()

    @router.get("/api/recording_contents", responses=refusal(503, "a file cannot be read"))
    def recording_contents() -> ContentsMessage:
        """Settings, map, robot and models, as they are now."""
        try:
            result = contents()
        except (BrickPoseError, OSError) as error:
            raise HTTPException(503, str(error)) from error
        files = [
            AttachmentMessage(
                name=attachment.name, data=base64.b64encode(attachment.data).decode("ascii")
            )
            for attachment in result.attachments
        ]
        return ContentsMessage(facts=result.facts, attachments=files)

    return router
