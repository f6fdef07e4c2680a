"""Journey: a drive to goals, as a programme of the engine."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from app.engine.driving import Programme
from app.features.navigation.messages import CurveMessage, LineMessage, NavigateCommand
from robot.driving.figure_eight import FigureEight
from robot.errors import CommandError
from robot.geometry import Pose2, Twist2
from robot.navigation.goal import Goal

if TYPE_CHECKING:
    from robot.navigation.curves import ClosedCurve
    from robot.navigation.line_follower import LineFollower
    from robot.navigation.navigator import Navigator

MODE = "navigate"


class Helm:
    """The velocity that a journey wants now: who navigates sets it, and the drive takes it."""

    def __init__(self) -> None:
        self.twist = Twist2()
        self.taken = True
        """Whether the drive has taken it since it was set; it does not while nobody renews it."""
        self.navigator: Navigator | LineFollower | None = None
        """Who steers; None before the first tick."""
        self.canceled = False
        """Whether somebody ended the journey."""

    def set(self, twist: Twist2) -> None:
        """Set the velocity of the next tick."""
        self.twist, self.taken = twist, False

    def velocity(self, elapsed: float) -> Twist2:
        """Return the velocity; when the journey began does not matter."""
        self.taken = True
        return self.twist


@dataclass(frozen=True, kw_only=True)
class Journey(Programme):
    """A drive to goals."""

    goals: tuple[Goal, ...]
    name: str | int | None = None
    """By which its sender knows it."""
    repeat: bool = False
    curve: CurveMessage | None = None
    """What it drives lap after lap, in place of goals."""
    line: LineMessage | None = None
    """What it follows in place of goals."""
    planner: str | None = None
    controller: str | None = None
    """By name; None are those of the settings."""
    began: float
    """Stamp of its command [s]."""
    helm: Helm = field(repr=False)

    @classmethod
    def of(cls, command: NavigateCommand, stamp: float) -> Journey:
        """Return the journey that a command wants at a stamp [s]."""
        goals = tuple(Goal(each.x, each.y, each.theta) for each in command.poses or ())
        helm = Helm()
        return cls(
            MODE,
            helm.velocity,
            anywhere=True,
            goals=goals,
            name=command.id,
            repeat=command.repeat,
            curve=command.curve,
            line=command.line,
            planner=command.planner,
            controller=command.controller,
            began=stamp,
            helm=helm,
        )


def curve_of(message: CurveMessage, eight: FigureEight) -> ClosedCurve:
    """Return the curve that is asked for; what is not said of it is the figure-eight's.

    Raises:
        CommandError: there is no such curve.
    """
    from robot.navigation.curves import ClosedCurve, CurveError  # noqa: PLC0415 - the first curve

    start = message.start
    if start is not None and start.theta is None:
        raise CommandError("the curve's start has no theta; valid is a number of radians")
    pose = None if start is None else Pose2(start.x, start.y, start.theta or 0.0)
    try:
        return ClosedCurve(message.shape, message.size or eight.radius, message.points, pose)
    except CurveError as error:
        raise CommandError(f"{error}") from error


RENEWAL = Programme(MODE, Helm().velocity)
"""Renews whatever journey there is."""
