"""Sensed: what a navigator knows of one tick."""

from __future__ import annotations

from dataclasses import dataclass

from robot.geometry import Pose2, Twist2
from robot.localization.estimate import Integrity
from robot.navigation.possible_places import Glimpse

STANDS_V, STANDS_OMEGA = 0.004, 0.02
"""A robot that is slower stands [m/s, rad/s]."""


@dataclass(frozen=True)
class Sensed:
    """What a navigator knows of one tick."""

    stamp: float
    pose: Pose2 | None
    """The estimate now; None while there is none."""
    twist: Twist2
    """As the wheels measure it."""
    integrity: Integrity
    odom: Pose2 = Pose2()
    """The robot in the odometry's frame."""
    view: Glimpse | None = None
    """What it saw last; None before that."""
    places: tuple[Pose2, ...] = ()
    """Where it may be now, by its filter."""
    spread: float = 0.0
    """Largest standard deviation of the place [m], by its filter alone."""

    @property
    def stands(self) -> bool:
        """Whether the robot stands."""
        return abs(self.twist.v) < STANDS_V and abs(self.twist.omega) < STANDS_OMEGA
