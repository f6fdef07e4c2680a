"""Motion model of a robot that may move any way while it turns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.models.turn_and_go import Legs, sample_legs, spread_of


@dataclass(frozen=True, slots=True)
class OmniMotion:
    """Odometry motion model for holonomic robots (nav2's OmniMotionModel).

    The step goes straight to where it ends, whatever the heading. It errs along its way by
    alpha3 distance^2 + alpha4 turn^2, across it by alpha5 distance^2 + alpha4 turn^2, and in
    heading by alpha1 turn^2 + alpha2 distance^2, all variances.
    """

    alpha1: float
    """Variance of the turn by turn squared [rad^2/rad^2]."""
    alpha2: float
    """Variance of the turn by distance squared [rad^2/m^2]."""
    alpha3: float
    """Variance along the way by distance squared [m^2/m^2]."""
    alpha4: float
    """Variance along and across the way by turn squared [m^2/rad^2]."""
    alpha5: float
    """Variance across the way by distance squared [m^2/m^2]."""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw where each particle went."""
        return sample_legs(poses, _legs(moved), self._deviations(moved), rng)

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance (3, 3) [m, m, rad] of where the step ends, seen from its start."""
        return moved, spread_of(_legs(moved), np.diag(np.square(self._deviations(moved))))

    def _deviations(self, moved: Pose2) -> Legs:
        square = moved.x**2 + moved.y**2
        by_turn = self.alpha4 * moved.theta**2
        return Legs(
            0.0,
            math.sqrt(self.alpha3 * square + by_turn),
            math.sqrt(self.alpha5 * square + by_turn),
            math.sqrt(self.alpha1 * moved.theta**2 + self.alpha2 * square),
        )


def _legs(moved: Pose2) -> Legs:
    bearing = math.atan2(moved.y, moved.x)
    return Legs(bearing, math.hypot(moved.x, moved.y), 0.0, moved.theta - bearing)
