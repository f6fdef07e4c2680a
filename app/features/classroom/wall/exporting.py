"""Exports the recordings of a class: one archive, with a folder for each student whose robot runs.

They come from the students' servers, which are confined: a link in a student's folder leads the
wall nowhere, and a class on several machines works as one on this.
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import quote

from fastapi import APIRouter
from fastapi.responses import FileResponse
from starlette.background import BackgroundTask

from app.features.classroom.wall.followed import FollowedServer
from app.features.classroom.wall.wall import Wall

MOST_OF_EACH = 256 << 20
"""The newest recordings of each student, up to so many bytes together. Half or twice of it changes
what a class of thirty can put on the teacher's disk: 4 or 15 GB."""
BLOCK = 1 << 20
LEFT_OUT = "left_out.txt"


def export_router(wall: Wall) -> APIRouter:
    """Return the route of the archive."""
    router = APIRouter()

    @router.get("/api/recordings.zip")
    def recordings() -> FileResponse:
        folder = Path(tempfile.mkdtemp(prefix="brickpose-"))
        try:
            archive = folder / "recordings.zip"
            pack(wall.servers(), archive)
        except BaseException:
            shutil.rmtree(folder)
            raise
        away = BackgroundTask(shutil.rmtree, folder)
        return FileResponse(archive, filename=archive.name, background=away)

    return router


def pack(servers: Mapping[str, FollowedServer], archive: Path) -> None:
    """Write the archive; what could not be had, or was too much, is named in it.

    Args:
        servers: those that run, by whose they are.
        archive: where it is written; recordings are compressed already, so it is not.
    """
    left_out: list[str] = []
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_STORED) as made:
        for login, server in servers.items():
            _pack_one(login, server, made, left_out.append)
        if left_out:
            made.writestr(LEFT_OUT, "\n".join((*left_out, "")))


def _pack_one(
    login: str, server: FollowedServer, made: zipfile.ZipFile, leave_out: Callable[[str], object]
) -> None:
    room = MOST_OF_EACH
    try:
        with server.opened("api/recordings") as answer:
            listed: list[dict[str, Any]] = json.load(answer)
        names = [str(each["name"]) for each in listed]
    except (OSError, ValueError, KeyError, TypeError) as error:
        leave_out(f"{login}: {error}")
        return
    for name in dict.fromkeys(names):
        # A student's server says so, and a student's code may have changed it.
        place = f"{login}/{re.sub(r'[^-A-Za-z0-9_.]', '_', name).lstrip('.')}.mcap"
        try:
            with server.opened(f"api/recordings/{quote(name, safe='')}") as answer:
                size = int(answer.headers.get("Content-Length") or MOST_OF_EACH + 1)
                if size > room:
                    leave_out(f"{place}: {size >> 20} MB more than there is room for")
                    continue
                room -= size
                with made.open(place, "w", force_zip64=True) as file:
                    _copy(answer, file, size)
        except (OSError, ValueError) as error:
            leave_out(f"{place}: {error}")


def _copy(source: BinaryIO, target: Any, size: int) -> None:
    while size and (block := source.read(min(size, BLOCK))):
        size -= len(block)
        target.write(block)
