"""Commands to the robot and the filter, and their answers."""

from __future__ import annotations

from collections.abc import Collection
from typing import Annotated, Literal

from pydantic import AwareDatetime, Field, ValidationError

from app.languages.marking import phrase
from app.messages.message import CommandMessage, Layer, Message, Metres, Radians

Command = CommandMessage
"""Any command; ``app/engine/commands.py`` has the table of all."""

MOST_POSES = 20_000
"""Most poses from which a filter can be started."""
LONGEST_COMMAND = 2_000_000
"""Longest command [characters]; 20,000 poses with weights are shorter."""


class SetPoseCommand(CommandMessage):
    """Tell the filter where the robot is, and how sure that is."""

    type: Literal["set_pose"]
    x: Metres
    y: Metres
    theta: Radians
    sd_xy: Annotated[float, Field(gt=0, le=100)] | None = None
    sd_theta: Annotated[float, Field(gt=0, le=10)] | None = None
    covariance: Annotated[list[float], Field(min_length=9, max_length=9)] | None = None
    """9 numbers by rows [m^2, m rad, rad^2], symmetric and positive semi-definite, instead of the
    standard deviations."""


class SetParticlesCommand(CommandMessage):
    """Start the filter from given poses: the robot is at or near one of them."""

    type: Literal["set_particles"]
    poses: Annotated[
        list[tuple[Metres, Metres, Radians]], Field(min_length=1, max_length=MOST_POSES)
    ]
    """x, y, theta of each pose."""
    weights: Annotated[list[Annotated[float, Field(ge=0)]], Field(max_length=MOST_POSES)] | None = (
        None
    )
    """How likely each pose is, on any scale; null is equally likely."""


class ScatterCommand(CommandMessage):
    """Spread the cloud over the whole field: the robot may be anywhere."""

    type: Literal["scatter"]


class UndoCommand(CommandMessage):
    """Take back the last set_pose, set_particles or scatter: restore what was believed before."""

    type: Literal["undo"]


class PlaceCommand(CommandMessage):
    """Put the simulated robot elsewhere; the filter does not learn of it."""

    type: Literal["place"]
    x: Metres
    y: Metres
    theta: Radians


class PauseCommand(CommandMessage):
    """Stop updating the filter by measurements; odometry still moves the cloud."""

    type: Literal["pause"]


class ResumeCommand(CommandMessage):
    """Update the filter again."""

    type: Literal["resume"]


class UpdateCommand(CommandMessage):
    """Update once with the next frame, even if the filter is paused or the robot stands still."""

    type: Literal["update"]


class ResetCommand(CommandMessage):
    """Restore the filter's configured parameters, and put the cloud at the start pose."""

    type: Literal["reset"]


class SetCalibrationCommand(CommandMessage):
    """Change what is known of the robot: how it differs from its description.

    Values that are left out stay as they are.
    """

    type: Literal["set_calibration"]
    values: Annotated[dict[str, float], Field(min_length=1, max_length=11)]
    """Differences by name, in the units of the profile's file [rad, m, s, relative]."""
    sd: Annotated[dict[str, float], Field(max_length=11)] = Field(default_factory=dict)
    """Their standard deviations; a value without one is as uncertain as in a robot built by
    hand."""
    made: AwareDatetime | None = None
    """When it was measured; null means when the other values were."""
    source: Annotated[str, Field(max_length=200)] = "a command"
    """What it was measured by."""
    fit: Annotated[dict[str, bool | float | list[str]], Field(max_length=8)] | None = None
    """How well it fits (``[fit]`` of a profile); null leaves what was said of the other values."""


class SetParametersCommand(CommandMessage):
    """Change parameters of the filter: all or none; ``/api/parameters`` lists their names."""

    type: Literal["set_parameters"]
    values: Annotated[dict[str, float | str | bool], Field(min_length=1, max_length=64)]


class UseFieldCommand(CommandMessage):
    """Switch to another field: a simulated robot is put there; a real one has to be.

    The robot stands meanwhile, and a running recording ends.
    """

    type: Literal["use_field"]
    name: Annotated[str, Field(min_length=1, max_length=200)]
    """One of ``/api/fields``, or generated- and a number."""


class ShowCommand(CommandMessage):
    """Switch a layer of the 3D view on or off; all viewers share that view."""

    type: Literal["show"]
    layer: Layer
    visible: bool


class PingCommand(CommandMessage):
    """Do nothing; the stamp of the answer can be used to align clocks."""

    type: Literal["ping"]


class AckMessage(Message):
    """The command was accepted."""

    type: Literal["ack"] = "ack"
    id: int | str | None
    stamp: float | None
    """The robot's clock when the answer was written, to align the clocks [s]."""


class ErrorMessage(Message):
    """The command was refused, and why."""

    type: Literal["error"] = "error"
    id: int | str | None
    message: str


def in_words(error: ValidationError, known: Collection[str] = ()) -> str:
    """Return the first mistake and where it is, in words; ``known`` keys are valid there."""
    first = error.errors(include_url=False, include_input=False)[0]
    path = ".".join(str(part) for part in first["loc"])
    if first["type"] == "extra_forbidden" and known:
        valid = ", ".join(map(repr, known))  # quoted, they are not translated
        return phrase(f"{path} is unknown; valid are {valid}")
    return f"{path}: {first['msg']}" if path else first["msg"]
