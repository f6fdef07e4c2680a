"""Base class and common types of all messages."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

LONGEST_ID = 200
"""Longest id of a command [characters]; the answer repeats it."""


Layer = Literal["particles", "headings", "rays", "covariance", "paths", "truth", "camera"]
Metres = Annotated[float, Field(ge=-1e4, le=1e4)]
Radians = Annotated[float, Field(ge=-1e3, le=1e3)]


class Message(BaseModel):
    """Base of all messages: frozen, with finite numbers, and without unknown keys."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


def _short(name: int | str | None) -> int | str | None:
    if isinstance(name, str) and len(name) > LONGEST_ID:
        raise ValueError(f"an id has at most {LONGEST_ID} characters")
    return name


class CommandMessage(Message):
    """Base of all commands; a number must be a number, not a text or a truth value."""

    model_config = ConfigDict(strict=True)

    id: Annotated[int | str | None, AfterValidator(_short)] = None
    """Repeated in the answer."""

    @property
    def kind(self) -> str:
        """The word that tells it from other commands: its ``type`` on the wire."""
        word: str = vars(self)["type"]
        return word
