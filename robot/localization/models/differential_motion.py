"""Odometry motion model: a turn, a straight and a turn, each with its own error."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.models.turn_and_go import Legs, sample_legs, spread_of

STANDING_M = 5e-4
"""Below this the direction of a step [m] is the encoders' rounding, not a direction."""


@dataclass(frozen=True, slots=True)
class DifferentialMotion:
    """Odometry motion model (Probabilistic Robotics, Table 5.6; nav2's DifferentialMotionModel).

    The step is a turn, a straight, and a turn. As in nav2 the alphas are variances: the variance
    of a turn is alpha1 turn^2 + alpha2 distance^2, that of the distance alpha3 distance^2 +
    alpha4 (turn1^2 + turn2^2).
    """

    alpha1: float
    """Variance of a turn by turn squared [rad^2/rad^2]."""
    alpha2: float
    """Variance of a turn by distance squared [rad^2/m^2]."""
    alpha3: float
    """Variance of the distance by distance squared [m^2/m^2]."""
    alpha4: float
    """Variance of the distance by turn squared [m^2/rad^2]."""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw where each particle went."""
        legs = _legs(moved)
        return sample_legs(poses, legs, self._deviations(legs), rng)

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance (3, 3) [m, m, rad] of where the step ends, seen from its start."""
        legs = _legs(moved)
        return moved, spread_of(legs, np.diag(np.square(self._deviations(legs))))

    def _deviations(self, legs: Legs) -> Legs:
        distance = math.hypot(legs.ahead, legs.aside)
        turn1, turn2 = _either_way(legs.turn), _either_way(legs.last)
        of_distance = self.alpha3 * distance**2 + self.alpha4 * (turn1**2 + turn2**2)
        return Legs(
            math.sqrt(self.alpha1 * turn1**2 + self.alpha2 * distance**2),
            math.sqrt(of_distance),
            0.0,
            math.sqrt(self.alpha1 * turn2**2 + self.alpha2 * distance**2),
        )


def _legs(moved: Pose2) -> Legs:
    distance = math.hypot(moved.x, moved.y)
    # Turning on the spot has no direction of travel: the step is taken as it is, then a turn.
    if distance <= STANDING_M:
        return Legs(0.0, moved.x, moved.y, moved.theta)
    turn = math.atan2(moved.y, moved.x)
    return Legs(turn, distance, 0.0, wrap_angle(moved.theta - turn))


def _either_way(turn: float) -> float:
    """The smaller turn, forward or in reverse: driving backwards is not a half turn."""
    return min(abs(turn), abs(wrap_angle(turn + math.pi)))
