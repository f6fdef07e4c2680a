"""The student's file, read and written from the page by who may have code run here."""

from __future__ import annotations

import hashlib
import ipaddress
from pathlib import Path
from typing import Annotated

from fastapi import APIRouter, HTTPException, Request
from pydantic import Field

from app.features.course.source import LONGEST, read_source
from app.files import atomic_file
from app.languages.marking import phrase
from app.messages.answers import refusal
from app.messages.message import Message
from app.page.token_guard import CODE, may_run_code
from robot.settings import SettingError

ELSEWHERE = phrase(
    "Only a browser on the robot's own computer may write this file: it is run there."
)
NO_CODE = phrase(
    "Where a token is asked for, the page runs no code, unless brickpose is started with "
    "--allow-code; any editor on the robot's own computer may write this file."
)
FORWARDED = ("forwarded", "x-forwarded-for", "x-forwarded-host", "x-real-ip", "via")
"""Headers by which a proxy tells that a request comes from elsewhere, although it does not."""
REPLACED = "\ufffd"
"""Stands in a text for bytes that are none."""
CHANGED = phrase("The file was changed meanwhile; load it again.")


class FileMessage(Message):
    """The text of the student's file."""

    text: Annotated[str, Field(max_length=LONGEST)]
    version: str
    """Tells texts apart; who saves a text names the version that it was made from."""


def student_file_router(file: Path) -> APIRouter:
    """Let a page read and write a file, which this program runs: not every page may."""
    router = APIRouter()

    @router.get("/api/student_file", responses=refusal(403, ELSEWHERE))
    def student_file(request: Request) -> FileMessage:
        """The student's file."""
        _require_here(request)
        return _read(file)

    @router.put(
        "/api/student_file",
        responses=refusal(403, ELSEWHERE) | refusal(409, "it was changed, or cannot be written"),
    )
    def write(request: Request, wanted: FileMessage) -> FileMessage:
        """Write the student's file; the answer has its new version."""
        _require_here(request)
        if _read(file).version != wanted.version:
            raise HTTPException(409, CHANGED)
        try:
            with atomic_file(file) as unfinished:
                unfinished.write_text(wanted.text, encoding="utf-8", newline="\n")
        except OSError as error:
            raise HTTPException(
                409, phrase(f"{file.name} cannot be written: {error.strerror}")
            ) from error
        return _read(file)

    return router


def _read(file: Path) -> FileMessage:
    try:
        text = read_source(file)
    except SettingError as error:
        raise HTTPException(409, str(error)) from error
    if REPLACED in text:  # it would be lost when the text is saved
        raise HTTPException(
            409, phrase(f"{file.name} is not in UTF-8; any other editor can mend that")
        )
    return FileMessage(text=text, version=hashlib.sha256(text.encode()).hexdigest()[:16])


def _require_here(request: Request) -> None:
    """Refuse other computers: a file that is run is worth more than the right to drive.

    Behind a proxy all requests come from this computer. Who has a proxy asks for a token, and
    where one is asked for, the address does not count, but only whether code is allowed.
    """
    if CODE in request.scope:
        if not may_run_code(request.scope):
            raise HTTPException(403, NO_CODE)
        return
    if any(name in request.headers for name in FORWARDED):
        raise HTTPException(403, ELSEWHERE)
    try:
        address = ipaddress.ip_address(request.client.host if request.client else "")
    except ValueError:
        raise HTTPException(403, ELSEWHERE) from None
    own = getattr(address, "ipv4_mapped", None) or address
    if not own.is_loopback:
        raise HTTPException(403, ELSEWHERE)
