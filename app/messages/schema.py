"""The JSON schema of every message, for the frontend's types and the page of documentation."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import TypeAdapter

from app.messages import commands, driving_commands, hand_commands, map_commands
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
from app.messages.floor_grid import FloorGridMessage
from app.messages.lens import LensMessage, LensRequest, LensStatusMessage
from app.messages.message import CommandMessage
from app.messages.recordings import ChangeMessage, RecordingEntry
from app.messages.telemetry import PictureMessage, TelemetryMessage
from app.messages.weighing import (
    HandStepMessage,
    HeadingsMessage,
    LandscapeMessage,
    PoseFitsMessage,
)


def schema(added: Iterable[type[CommandMessage]] = ()) -> dict[str, Any]:
    """Return the JSON schema of every message, and of commands that features have added."""
    adapters: list[Any] = [
        *dict.fromkeys((*_commands(), *added)),
        TelemetryMessage, PictureMessage, AckMessage, ErrorMessage, AccessMessage,
        HealthMessage, FieldMessage, ParameterMessage, ProfileMessage, ProblemsMessage,
        FloorGridMessage, LanguageMessage, RecordingEntry, ChangeMessage,
        LensStatusMessage, LensRequest, LensMessage,
        PoseFitsMessage, LandscapeMessage, HeadingsMessage, HandStepMessage,
    ]  # fmt: skip
    _, definitions = TypeAdapter.json_schemas(
        [(adapter, "validation", TypeAdapter(adapter)) for adapter in adapters]
    )
    return definitions


def _commands() -> list[type[CommandMessage]]:
    """Return all commands of this room."""
    modules = commands, driving_commands, hand_commands, map_commands
    return [
        item
        for module in modules
        for item in vars(module).values()
        if isinstance(item, type)
        and issubclass(item, CommandMessage)
        and item is not CommandMessage
    ]
