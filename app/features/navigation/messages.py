"""Commands that send the robot to goals, and the message of its way."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import ConfigDict, Field

from app.messages.message import CommandMessage, Message, Metres, Radians

MOST_GOALS, MOST_POINTS = 1000, 1000
"""Of one journey, and of one curve."""
MOST_ZONES, MOST_CORNERS = 100, 200
"""Keep-out zones, and the corners of each."""
Point = Annotated[tuple[Metres, Metres], Field(strict=False)]
"""x, y [m] in the map, as an array of JSON or a tuple."""
PolygonMessage = Annotated[list[Point], Field(min_length=3, max_length=MOST_CORNERS)]
"""x, y [m] of the corners."""


class GoalMessage(Message):
    """A goal in the map."""

    model_config = ConfigDict(strict=True)

    x: Metres
    y: Metres
    theta: Radians | None = None
    """The heading there; null is any."""


class CurveMessage(Message):
    """A closed curve, which is driven lap after lap."""

    model_config = ConfigDict(strict=True)

    shape: Literal["figure_eight", "circle", "square", "points"]
    size: Annotated[float, Field(ge=0.02, le=10)] | None = None
    """Radius of the circles, or half of the square's side [m]; null is the figure-eight's radius
    in the settings."""
    speed: Annotated[float, Field(ge=0.01, le=2)] | None = None
    """Speed along the curve where nothing asks for less [m/s]; null is the figure-eight's in the
    settings."""
    points: Annotated[tuple[Point, ...], Field(strict=False, max_length=MOST_POINTS)] = ()
    """x, y [m] in the map, of the shape points: the curve leads smoothly through them, and from the
    last one back to the first."""
    start: GoalMessage | None = None
    """Where a shape begins, and in which direction; null is where the robot stands, as it stands.
    Circles are driven to the left first, and the square's corners are left ones."""


class LineMessage(Message):
    """Tape that the robot follows by its camera, without a map."""

    model_config = ConfigDict(strict=True)

    speed: Annotated[float, Field(ge=0.01, le=2)] = 0.12
    """Speed where the tape is straight [m/s]; in bends it is slower."""


class NavigateCommand(CommandMessage):
    """Drive to goals, one after the other; along a closed curve, lap after lap; or along tape.

    It holds until the robot is there, as long as its sender is connected and nobody else drives.
    """

    type: Literal["navigate"]
    poses: Annotated[list[GoalMessage], Field(min_length=1, max_length=MOST_GOALS)] | None = None
    """Where to; null, without a curve or a line, only renews the journey that there is."""
    curve: CurveMessage | None = None
    """The curve, in place of goals."""
    line: LineMessage | None = None
    """Follow the nearest tape in sight to its end, in place of goals."""
    repeat: bool = False
    """Whether to begin again after the last goal."""
    planner: Annotated[str, Field(max_length=200)] | None = None
    """By name; null is that of the settings."""
    controller: Annotated[str, Field(max_length=200)] | None = None
    """By name; null is that of the settings."""
    renewed: bool = False
    """Whether the sender renews it itself, as ``drive``; the robot stands when that ends."""


class SetWallsCommand(CommandMessage):
    """Say what the robot must not touch on its way to goals, besides shapes on the floor.

    It holds until the field is loaded again.
    """

    type: Literal["set_walls"]
    tape: Literal["wall", "ignored"] | None = None
    """Whether the robot may cross tape; null leaves that as it is."""
    zones: Annotated[list[PolygonMessage], Field(max_length=MOST_ZONES)] | None = None
    """All keep-out zones: each by its corners; an empty list removes them, null leaves them."""


class TakePlaceCommand(CommandMessage):
    """Start the filter where a robot that has looked around must be; a journey says so itself."""

    type: Literal["take_place"]
    x: Metres
    y: Metres
    theta: Radians
    covariance: Annotated[list[float], Field(min_length=9, max_length=9)]
    """By rows [m^2, m rad, rad^2], symmetric and positive semi-definite."""


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


class WallsMessage(Message):
    """What the robot does not touch on its way to goals, besides shapes on the floor."""

    tape: Literal["wall", "ignored"]
    """Whether it may cross tape."""
    zones: list[list[list[float]]]
    """Keep-out zones: x, y [m] of their corners."""


class CostsMessage(Message):
    """The inflation layer: what each cell costs on a way to a goal, in nav2's numbers."""

    x: float
    y: float
    """Lower left corner of the cells in the map [m]."""
    step: float
    """Side of a cell [m]."""
    columns: int
    rows: int
    inflation_radius: float
    """Walls farther away cost nothing [m]."""
    cost_scaling_factor: float
    """How soon the cost falls with the distance [1/m]."""
    cells: str
    """base64 of a byte a cell, row by row from below: 254 is a wall, 253 where the robot cannot
    turn, 252 to 1 the nearer a wall the more, 0 free."""


MESSAGES = (NavigationPathMessage, WallsMessage, CostsMessage)
