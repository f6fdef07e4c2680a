"""Odometry motion models: a step is a turn, a straight and a turn, each with its own error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.kernels.sampling import noise_key
from robot.localization.kernels.steps import noisy_step

STANDING_M = 5e-4
"""The direction of a shorter step [m] is only the rounding of the encoders."""


class Legs(NamedTuple):
    """The parts of a step, or their standard deviations."""

    turn: float
    """First turn, toward the end of the step [rad]."""
    ahead: float
    """Distance ahead [m]."""
    aside: float
    """Distance to the left [m]."""
    last: float
    """Last turn [rad]."""


def sample_legs(poses: Array, legs: Legs, deviations: Legs, rng: np.random.Generator) -> Array:
    """Draw the ends of a step from poses (n, 3); each part has an independent normal error."""
    return noisy_step(poses, (*legs,), (*deviations,), noise_key(rng))


def spread_of(legs: Legs, covariance: Array) -> Array:
    """Return the covariance (3, 3) [m, m, rad] of a step's end, seen from its start.

    For small errors it is J C J^T, with the covariance C (4, 4) of the parts and the Jacobian J of
    the end by the parts.
    """
    c, s = math.cos(legs.turn), math.sin(legs.turn)
    x, y = c * legs.ahead - s * legs.aside, s * legs.ahead + c * legs.aside
    J = np.array([[-y, c, -s, 0.0], [x, s, c, 0.0], [1.0, 0.0, 0.0, 1.0]])
    end: Array = J @ covariance @ J.T
    return end


@dataclass(frozen=True, slots=True)
class DifferentialMotion:
    """Odometry motion model (Probabilistic Robotics, Table 5.6; nav2's DifferentialMotionModel).

    The step is a turn, a straight, and a turn. As in nav2, the alphas are variances. The variance
    of a turn is alpha1 turn^2 + alpha2 distance^2; the variance of the distance is
    alpha3 distance^2 + alpha4 (turn1^2 + turn2^2).
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
        """Draw the pose of each particle after the step."""
        legs = _legs(moved)
        return sample_legs(poses, legs, self._deviations(legs), rng)

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Return mean and covariance (3, 3) [m, m, rad] of the step's end, seen from its start."""
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
    # A turn on the spot has no direction of travel: the small shift comes first, then the turn.
    if distance <= STANDING_M:
        return Legs(0.0, moved.x, moved.y, moved.theta)
    turn = math.atan2(moved.y, moved.x)
    return Legs(turn, distance, 0.0, wrap_angle(moved.theta - turn))


def _either_way(turn: float) -> float:
    """Return the smaller turn, forward or in reverse: driving backwards is not a half turn."""
    return min(abs(turn), abs(wrap_angle(turn + math.pi)))


@dataclass(frozen=True, slots=True)
class OmniMotion:
    """Odometry motion model for holonomic robots (nav2's OmniMotionModel).

    The step goes straight to its end, with any heading. The variances are
    alpha3 distance^2 + alpha4 turn^2 along the step, alpha5 distance^2 + alpha4 turn^2 across it,
    and alpha1 turn^2 + alpha2 distance^2 in heading.
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
        """Draw the pose of each particle after the step."""
        return sample_legs(poses, _straight_way(moved), self._deviations(moved), rng)

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Return mean and covariance (3, 3) [m, m, rad] of the step's end, seen from its start."""
        return moved, spread_of(_straight_way(moved), np.diag(np.square(self._deviations(moved))))

    def _deviations(self, moved: Pose2) -> Legs:
        square = moved.x**2 + moved.y**2
        by_turn = self.alpha4 * moved.theta**2
        return Legs(
            0.0,
            math.sqrt(self.alpha3 * square + by_turn),
            math.sqrt(self.alpha5 * square + by_turn),
            math.sqrt(self.alpha1 * moved.theta**2 + self.alpha2 * square),
        )


def _straight_way(moved: Pose2) -> Legs:
    bearing = math.atan2(moved.y, moved.x)
    return Legs(bearing, math.hypot(moved.x, moved.y), 0.0, moved.theta - bearing)


@dataclass(frozen=True, slots=True)
class StationaryMotion:
    """Ignores odometry and spreads the particles a little: the simplest model, for comparison.

    It is also the only one for a robot without wheel sensors; that must move slowly.
    """

    sd_xy: float
    """Standard deviation of the place in a step [m]."""
    sd_theta: float
    """Standard deviation of the heading in a step [rad]."""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Spread the particles about their poses."""
        spread = Legs(0.0, self.sd_xy, self.sd_xy, self.sd_theta)
        return sample_legs(poses, Legs(0.0, 0.0, 0.0, 0.0), spread, rng)

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Return mean and covariance (3, 3) [m, m, rad] of the step's end: about its start."""
        return Pose2(), np.diag(np.square([self.sd_xy, self.sd_xy, self.sd_theta]))
