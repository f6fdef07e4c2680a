"""Motions that are driven again and again: straights, turns, arcs and squares."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robot.geometry import Pose2, Twist2

ARC_RADIUS = 0.19
"""As the circles of the paper's figure-eight [m]."""

SIDE = 1.0
"""Of straights and squares [m]."""


@dataclass(frozen=True, slots=True)
class Leg:
    """A stretch along one curve, until odometry says that its end is reached."""

    distance: float
    """To go [m]; negative is backwards."""
    turn: float
    """To turn [rad]; positive is to the left."""

    def share(self, step: Pose2) -> float:
        """What part of the leg a small step along it is."""
        return step.theta / self.turn if self.turn else step.x / self.distance

    def twist(self, rate: float) -> Twist2:
        """The twist along the leg at so many legs a second."""
        return Twist2(self.distance * rate, self.turn * rate)


def arc(radius: float, turn: float) -> Leg:
    """A leg along a circle."""
    return Leg(radius * abs(turn), turn)


def square(way: int) -> tuple[Leg, ...]:
    """Four sides and four corners; way 1 is to the left, anticlockwise."""
    return (Leg(SIDE, 0.0), Leg(0.0, way * math.pi / 2)) * 4


QUARTER = math.pi / 2

MOTIONS: dict[str, tuple[Leg, ...]] = {
    "straight_forward": (Leg(SIDE, 0.0),),
    "straight_back": (Leg(-SIDE, 0.0),),
    "turn_left_90": (Leg(0.0, QUARTER),),
    "turn_right_90": (Leg(0.0, -QUARTER),),
    "turn_left_360": (Leg(0.0, 4 * QUARTER),),
    "turn_right_360": (Leg(0.0, -4 * QUARTER),),
    "arc_left_270": (arc(ARC_RADIUS, 3 * QUARTER),),
    "arc_right_270": (arc(ARC_RADIUS, -3 * QUARTER),),
    "square_ccw": square(1),
    "square_cw": square(-1),
}
