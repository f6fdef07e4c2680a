"""How the interface's own description (``/openapi.json``) tells what else a route may answer."""

from __future__ import annotations

from typing import Any

from app.messages.message import Message

Responses = dict[int | str, dict[str, Any]]
"""By status, as FastAPI wants it."""


class RefusalMessage(Message):
    """Why a request cannot be answered."""

    detail: str


def refusal(status: int, words: str) -> Responses:
    """Describe a status that refuses a request, and when it does."""
    return {status: {"model": RefusalMessage, "description": words}}


def content(media_type: str) -> Responses:
    """Describe an answer that is no JSON."""
    return {200: {"content": {media_type: {"schema": {"type": "string", "format": "binary"}}}}}
