"""Commands that record and replay, and messages of the list of recordings."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from app.messages.message import CommandMessage, Message

LONGEST_NOTES = 2000
"""Longest notes about a recording [characters]."""


class RecordingEntry(Message):
    """One recording."""

    name: str
    """``/api/recordings/NAME`` serves the file."""
    size_bytes: int
    duration_s: float | None
    """Null if it is unknown."""
    unfinished: bool
    """Still being recorded, or cut off by a full disk or the end of the program; it can be read."""
    changed: float
    """When it was last written [s since 1970]."""
    notes: str


class ChangeMessage(Message):
    """What is to change of a recording; what is left out stays."""

    name: Annotated[str, Field(max_length=200)] | None = None
    notes: Annotated[str, Field(max_length=LONGEST_NOTES)] | None = None


class RecordCommand(CommandMessage):
    """Start a recording, or end the running one."""

    type: Literal["record"]
    on: bool


class OpenRecordingCommand(CommandMessage):
    """Replay a recording in place of the robot, whose motors stop."""

    type: Literal["open_recording"]
    name: Annotated[str, Field(max_length=200)]
    """Its name in ``/api/recordings``."""


class RunAgainCommand(CommandMessage):
    """Replay the last recording with the current parameters."""

    type: Literal["run_again"]


class CloseRecordingCommand(CommandMessage):
    """Go back from a recording that the page opened to the robot."""

    type: Literal["close_recording"]


class ReplayCommand(CommandMessage):
    """Change how a recording is replayed; values that are left out stay as they are."""

    type: Literal["replay"]
    paused: bool | None = None
    speed: Annotated[float, Field(ge=0.05, le=50)] | None = None
    """Seconds of the recording per second."""
    position_s: Annotated[float, Field(ge=0)] | None = None
    """Go to this time since the recording's beginning."""
    step: Annotated[int, Field(ge=-1000, le=1000)] | None = None
    """Go this many pictures forward (or back, if negative), and pause."""


MESSAGES = (RecordingEntry, ChangeMessage)
