"""Commands to drive, to stop, and to drive for a calibration."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from app.messages.message import CommandMessage


class DriveCommand(CommandMessage):
    """Drive; holds for ``cmd_vel_timeout`` unless renewed.

    Velocities beyond the limits are reduced to them.
    """

    type: Literal["drive"]
    v: Annotated[float, Field(ge=-10, le=10)]
    omega: Annotated[float, Field(ge=-100, le=100)]


class StopCommand(CommandMessage):
    """Stop at once, whoever drives."""

    type: Literal["stop"]


class FigureEightCommand(CommandMessage):
    """Drive the open-loop figure-eight.

    It holds as long as drive does, and continues if renewed. The robot stands until then; after
    five seconds the figure-eight begins again.
    """

    type: Literal["figure_eight"]
    start: bool = False
    """Whether to begin again; that is refused if the robot is known to leave the field."""
    speed: Annotated[float, Field(ge=0.01, le=2)] | None = None
    """Speed along the circles [m/s]; null means as configured. It may change during the drive."""


class TakeCommand(CommandMessage):
    """Take over from the client that drives, and end a stop that holds."""

    type: Literal["take"]
