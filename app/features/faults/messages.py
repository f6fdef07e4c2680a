"""The faults that a simulated robot can have, and the command that sets them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from app.messages.answers import ParameterMessage
from app.messages.message import CommandMessage, Message


class FaultsMessage(Message):
    """What can be wrong with a simulated robot and its camera."""

    faults: list[ParameterMessage]
    """Each with its value now; the default is the value at the start."""
    conditions: dict[str, dict[str, float | str]]
    """Values of each named condition of `brickpose evaluate integrity`."""


class SetFaultsCommand(CommandMessage):
    """Change what is wrong with the simulated robot and its camera, while it drives on."""

    type: Literal["set_faults"]
    values: Annotated[dict[str, float | str], Field(min_length=1, max_length=32)]
    """Values by name; ``/api/faults`` lists the names."""


MESSAGES = (FaultsMessage,)
