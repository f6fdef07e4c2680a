"""The JSON schema of every message, for the frontend's types and the page of documentation."""

from __future__ import annotations

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
from app.messages.commands import AckMessage, Command, ErrorMessage
from app.messages.floor_grid import FloorGridMessage
from app.messages.lens import LensMessage, LensRequest, LensStatusMessage
from app.messages.recordings import ChangeMessage, RecordingEntry
from app.messages.telemetry import PictureMessage, TelemetryMessage
from app.messages.weighing import (
    HandStepMessage,
    HeadingsMessage,
    LandscapeMessage,
    PoseFitsMessage,
)


def schema() -> dict[str, Any]:
    """Return the JSON schema of every message."""
    adapters: list[Any] = [
        TelemetryMessage, PictureMessage, Command, AckMessage, ErrorMessage, AccessMessage,
        HealthMessage, FieldMessage, ParameterMessage, ProfileMessage, ProblemsMessage,
        FloorGridMessage, LanguageMessage, RecordingEntry, ChangeMessage,
        LensStatusMessage, LensRequest, LensMessage,
        PoseFitsMessage, LandscapeMessage, HeadingsMessage, HandStepMessage,
    ]  # fmt: skip
    _, definitions = TypeAdapter.json_schemas(
        [(adapter, "validation", TypeAdapter(adapter)) for adapter in adapters]
    )
    return definitions
