"""Messages of the list of recordings."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from app.messages.message import Message

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
