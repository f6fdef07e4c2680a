"""``/api/recording_contents``: what a recording that is made elsewhere begins with."""

from __future__ import annotations

import base64
from collections.abc import Callable

from fastapi import APIRouter, HTTPException

from app.messages.message import Message
from app.recordings.attachments import Attachment, Contents


class AttachmentMessage(Message):
    """A file that goes into the recording."""

    name: str
    data: str
    """In base64."""


class ContentsMessage(Message):
    """Facts and files."""

    facts: dict[str, str]
    attachments: list[AttachmentMessage]

    def contents(self) -> Contents:
        """As a recording has them.

        Raises:
            ValueError: a file is no base64.
        """
        files = tuple(
            Attachment(one.name, base64.b64decode(one.data, validate=True))
            for one in self.attachments
        )
        return Contents(self.facts, files)


def contents_router(contents: Callable[[], Contents]) -> APIRouter:
    """Tells what is in a recording besides messages, so that one made elsewhere can be replayed."""
    router = APIRouter()

    @router.get("/api/recording_contents")
    def recording_contents() -> ContentsMessage:
        """Settings, map, robot and models, as they are now."""
        try:
            found = contents()
        except (OSError, ValueError) as error:
            raise HTTPException(503, str(error)) from error
        files = [
            AttachmentMessage(name=one.name, data=base64.b64encode(one.data).decode("ascii"))
            for one in found.attachments
        ]
        return ContentsMessage(facts=found.facts, attachments=files)

    return router
