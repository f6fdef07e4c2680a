"""SlipCheck: tells whether only the wheels lie, and how far they may have led an estimate.

Slip lasts for about a second and turns the robot, as two wheels never slip alike. It moves no robot
aside, as a floor does that is not as drawn, and it does not sway from one picture to the next, as
pictures do that come late by turns. While wheels slip, what scans see since then bounds the pose.

What half and twice of a constant change was found by ``brickpose evaluate integrity --map stub
square --start known --condition slippery all-at-once --first-seed 8300 --seeds 3``: of pictures on
a slippery floor 96.5 % are certain, of those with all errors at once 70.8 %.
"""

from __future__ import annotations

import math

import numpy as np

from robot.compiling import compiled
from robot.covariance import inverse, outer
from robot.geometry import Array, Pose2
from robot.localization.monitoring.step_sums import RECENT

SLIPS, SPREADS = 0.5, 1.5
"""What slipping wheels explain of a step between two pictures, as a share of it; and how many
standard deviations of poses explain. Half of both: a carried robot is found again after 1.3 s
instead of 1.1; twice: one that knew its place is certain of another for 1.3 s (``python -m
benchmarks.constants --few``; *stub*, seed 9001)."""
SLIDE = 0.25
"""Share of a way and of a turn by which slip may mislead, 1 sd. Half and twice: no claim changes.
"""
LEVER = 0.06
"""A turn of a radian counts as this way, about that of a wheel [m/rad]. Half: 69.2 % certain with
all errors at once; twice: 74.0 %."""
LEAST = 1e-10
"""Variance of a pose that does not slip [m², rad²]. Half and twice: no claim changes, as it only
keeps a matrix regular."""


class SlipCheck:
    """Compares where odometry and scans lead, from one picture to the next."""

    def __init__(self) -> None:
        """Begin without slip."""
        self.restart()

    def restart(self) -> None:
        """Begin again at a given pose."""
        self.covariance: Array = np.zeros((3, 3))
        """(3, 3) of how far slip may have led since scans saw it, along the map's axes [m, m, rad].
        """
        self._offset = Pose2()
        self._lasting = 0.0

    def observe(
        self, pose: Pose2, moved: Pose2, offset: Pose2, information: Array, elapsed: float
    ) -> None:
        """Take in a scan.

        Args:
            pose: the robot in the map.
            moved: the step by odometry that led there.
            offset: where it led by the scan, seen from where it led by odometry.
            information: (3, 3) of the scan alone on the pose, along the map's axes.
            elapsed: the time since the last scan [s].
        """
        before, self._offset = self._offset, offset
        same = offset.x * before.x / LEVER**2 + offset.theta * before.theta
        self._lasting = math.exp(-elapsed / RECENT) * self._lasting + same
        self.covariance = slid(self.covariance, pose.theta, moved.x, moved.theta, information)

    def explains(self, rest: Array, most: float) -> bool:
        """Whether slip explains steps that differ from odometry by more than ``most`` spreads.

        Args:
            rest: (3,) unexplained rest of steps ahead, aside and in heading, in spreads.
        """
        _, aside, heading = rest.tolist()
        return self._lasting > 0 and heading > max(aside, most)


@compiled()
def slid(covariance: Array, heading: float, way: float, turn: float, information: Array) -> Array:
    """Return how far slip may have led (3, 3): farther by a step, less far by what a scan sees.

    Args:
        covariance: the same before the step, along the map's axes [m, m, rad].
        heading: of the robot [rad].
        way: of the step by odometry [m].
        turn: of the step by odometry [rad].
        information: (3, 3) of the scan alone, along the map's axes.
    """
    ahead = np.array([math.cos(heading), math.sin(heading), 0.0])
    by_way, by_turn = SLIDE * abs(way), SLIDE * abs(turn)
    # Slip lasts, so standard deviations add up, not variances.
    before, turned = math.sqrt(ahead @ covariance @ ahead), math.sqrt(covariance[2, 2])
    wider = covariance + LEAST * np.eye(3) + (2 * before + by_way) * by_way * outer(ahead, ahead)
    wider[2, 2] += (2 * turned + by_turn) * by_turn
    return np.ascontiguousarray(inverse(inverse(wider) + information))
