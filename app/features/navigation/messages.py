"""Commands that send the robot to goals, and the message of its way."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from app.messages.message import CommandMessage, Message, Metres, Radians

MOST_GOALS = 1000


class GoalMessage(Message):
    """A goal in the map."""

    model_config = ConfigDict(strict=True)

    x: Metres
    y: Metres
    theta: Radians | None = None
    """The heading there; null is any."""


class NavigateCommand(CommandMessage):
    """Drive to goals, one after the other.

    It holds until the robot is there, as long as its sender is connected and nobody else drives.
    """

    type: Literal["navigate"]
    poses: Annotated[list[GoalMessage], Field(min_length=1, max_length=MOST_GOALS)] | None = None
    """Where to; null only renews the journey that there is."""
    repeat: bool = False
    """Whether to begin again after the last goal."""
    renewed: bool = False
    """Whether the sender renews it itself, as ``drive``; the robot stands when that ends."""


class CancelCommand(CommandMessage):
    """End the journey to a goal: the robot stands where it is."""

    type: Literal["cancel"]
    before: float | None = None
    """Only a journey that began before this time on the robot's clock [s]; null is any."""


class NavigationPathMessage(Message):
    """The way of a journey."""

    planned: float
    """As in telemetry."""
    goals: list[GoalMessage]
    path: list[tuple[float, float]]
    """x, y [m] along the way to the next goal; empty before it is planned."""


MESSAGES = (NavigationPathMessage,)
