"""The JSON schema of every message, for the frontend's types and the page of documentation."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any, get_args

from pydantic import TypeAdapter

from app.messages.answers import (
    AccessMessage,
    FieldMessage,
    HealthMessage,
    LanguageMessage,
    ParameterMessage,
    ProblemsMessage,
    ViewCameraMessage,
)
from app.messages.commands import AckMessage, ErrorMessage
from app.messages.message import Message
from app.messages.telemetry import PictureMessage, TelemetryMessage

MESSAGES: tuple[type[Message], ...] = (
    TelemetryMessage, PictureMessage, AckMessage, ErrorMessage, AccessMessage, HealthMessage,
    FieldMessage, ParameterMessage, ProblemsMessage, LanguageMessage, ViewCameraMessage,
)  # fmt: skip
"""What the core sends."""


def parts_of(messages: Iterable[type[Message]]) -> Iterator[type[Message]]:
    """Yield messages, and those that they have inside, each once."""
    pending, seen = list(messages), set[type[Message]]()
    while pending:
        message = pending.pop()
        if message not in seen:
            seen.add(message)
            yield message
            pending += _inside(message)


@cache
def _inside(message: type[Message]) -> tuple[type[Message], ...]:
    fields = message.model_fields.values()
    return tuple(part for field in fields for part in _messages_in(field.annotation))


def _messages_in(annotation: Any) -> list[type[Message]]:
    if isinstance(annotation, type) and issubclass(annotation, Message):
        return [annotation]
    return [message for part in get_args(annotation) for message in _messages_in(part)]


def schema(messages: Iterable[type[Message]]) -> dict[str, Any]:
    """Return the JSON schema of messages, and of all that they have inside, by their names."""
    _, definitions = TypeAdapter.json_schemas(
        [(each, "validation", TypeAdapter(each)) for each in dict.fromkeys(messages)]
    )
    by_name: dict[str, Any] = definitions["$defs"]
    return by_name
