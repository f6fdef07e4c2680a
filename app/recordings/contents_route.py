"""``/api/recording_contents``: facts and files for a recording that is made elsewhere."""

from __future__ import annotations

import base64
from collections.abc import Callable

from fastapi import APIRouter, HTTPException

from app.messages.answers import refusal
from app.messages.message import Message
from app.recordings.attachments import Attachment, Contents
from robot.errors import BrickPoseError


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
