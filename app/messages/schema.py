"""The JSON schema of every message, for the frontend's types and the page of documentation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import TypeAdapter

from app.messages.answers import (
    AccessMessage,
    FieldMessage,
    HealthMessage,
    LanguageMessage,
    ParameterMessage,
    ProblemsMessage,
    ProfileMessage,
)
from app.messages.commands import AckMessage, ErrorMessage
from app.messages.message import Message
from app.messages.telemetry import PictureMessage, TelemetryMessage

MESSAGES: tuple[type[Message], ...] = (
    TelemetryMessage, PictureMessage, AckMessage, ErrorMessage, AccessMessage, HealthMessage,
    FieldMessage, ParameterMessage, ProfileMessage, ProblemsMessage, LanguageMessage,
)  # fmt: skip
"""What the core sends."""


def schema(messages: Iterable[type[Message]]) -> dict[str, Any]:
    """Return the JSON schema of messages, and of all that they have inside, by their names."""
    _, definitions = TypeAdapter.json_schemas(
        [(each, "validation", TypeAdapter(each)) for each in dict.fromkeys(messages)]
    )
    by_name: dict[str, Any] = definitions["$defs"]
    return by_name
