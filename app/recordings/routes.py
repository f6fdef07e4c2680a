"""Lists recordings and serves their files; serves what a recording made elsewhere needs."""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from fastapi import APIRouter, HTTPException, Response
from fastapi.responses import FileResponse, StreamingResponse
from mcap.writer import MCAP0_MAGIC as MAGIC

from app.messages.answers import content, refusal
from app.messages.message import Message
from app.recordings.attachments import Attachment, Contents
from app.recordings.files.recorded import RecordingError
from app.recordings.files.recording_file import METADATA_FILE
from robot.errors import BrickPoseError

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,199}")
"""Valid names of recordings: none of them can lead out of the folder."""

LARGEST_METADATA = 1_000_000
"""Largest ``metadata.yaml`` [bytes]; BrickPose writes no larger one."""

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


@dataclass(frozen=True, slots=True)
class Listed:
    """One recording."""

    name: str
    file: Path
    size_bytes: int
    duration_s: float | None
    """Duration in ``metadata.yaml``; None if it is unknown."""
    unfinished: bool
    """Whether it is still being recorded, or was cut off."""
    changed: float
    """When it was last written [s since 1970]."""


def listed(parent: Path) -> list[Listed]:
    """Return all recordings in a folder, newest first; none if there is no such folder."""
    if not parent.is_dir():
        return []
    result = [_look(folder) for folder in parent.iterdir() if NAME.fullmatch(folder.name)]
    return sorted((each for each in result if each), key=lambda item: -item.changed)


def find(parent: Path, name: str) -> Listed:
    """Return a recording by its name.

    Raises:
        RecordingError: there is no such recording; lists some that exist.
    """
    result = _look(parent / name) if NAME.fullmatch(name) else None
    if result is None:
        some = ", ".join(item.name for item in listed(parent)[:5]) or "none yet"
        raise RecordingError(f"there is no recording {name!r}; valid are {some}")
    return result


def _look(folder: Path) -> Listed | None:
    """Return the recording in a folder; None for a link, which could lead anywhere."""
    path = folder / f"{folder.name}_0.mcap"
    try:
        if folder.is_symlink() or path.is_symlink() or not path.is_file():
            return None
        status = path.stat()
        with path.open("rb") as file:
            file.seek(max(0, status.st_size - len(MAGIC)))
            unfinished = status.st_size <= len(MAGIC) or file.read() != MAGIC
    except OSError:
        return None  # it was deleted meanwhile, or belongs to another user
    duration = _duration(folder / METADATA_FILE)
    return Listed(folder.name, path, status.st_size, duration, unfinished, status.st_mtime)


def _duration(path: Path) -> float | None:
    try:
        if path.stat().st_size > LARGEST_METADATA:
            return None
        content = yaml.load(path.read_bytes(), _Loader)
        nanoseconds = content["rosbag2_bagfile_information"]["duration"]["nanoseconds"]
        return int(nanoseconds) / 1e9
    except (OSError, yaml.YAMLError, LookupError, TypeError, ValueError):
        return None


MEDIA_TYPE = "application/octet-stream"
FILE = content(MEDIA_TYPE) | refusal(404, "no such recording")
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
