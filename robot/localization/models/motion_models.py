"""Motion models: where may a robot be that was here and moved so?

A motion model is a frozen dataclass with ``sample``; a student's own is the same thing, added to
``MOTION_MODELS`` or handed to the filter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2, compose, wrap_angle

STANDING_M = 5e-4
"""Below this the direction of a step [m] is the encoders' rounding, not a direction."""


class MotionModel(Protocol):
    """What any motion model offers."""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw where each particle went.

        Args:
            poses: (n, 3) particles [m, m, rad].
            moved: the step by odometry, seen from its start.
            rng: the only source of chance.

        Returns:
            (n, 3) particles after the step.
        """
        ...


@dataclass(frozen=True, slots=True)
class DifferentialMotion:
    """Odometry motion model (Probabilistic Robotics, Table 5.6; nav2's DifferentialMotionModel).

    The step is a turn, a straight, and a turn. As in nav2 the alphas are variances: the variance
    of a turn is alpha1 turn^2 + alpha2 distance^2, that of the distance alpha3 distance^2 +
    alpha4 (turn1^2 + turn2^2).
    """

    alpha1: float
    alpha2: float
    alpha3: float
    alpha4: float

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw where each particle went."""
        distance = math.hypot(moved.x, moved.y)
        # Turning on the spot has no direction of travel: the step is taken as it is, then a turn.
        standing = distance <= STANDING_M
        turn1 = 0.0 if standing else math.atan2(moved.y, moved.x)
        ahead, aside = (moved.x, moved.y) if standing else (distance, 0.0)
        turn2 = wrap_angle(moved.theta - turn1)
        small1, small2 = _either_way(turn1), _either_way(turn2)
        sd_turn1 = math.sqrt(self.alpha1 * small1**2 + self.alpha2 * distance**2)
        sd_turn2 = math.sqrt(self.alpha1 * small2**2 + self.alpha2 * distance**2)
        sd_distance = math.sqrt(self.alpha3 * distance**2 + self.alpha4 * (small1**2 + small2**2))
        noise = rng.standard_normal((3, len(poses)))
        first = turn1 + sd_turn1 * noise[0]
        travel = ahead + sd_distance * noise[1]
        last = turn2 + sd_turn2 * noise[2]
        turned = compose(poses, _turn(first))
        straight = np.column_stack([travel, np.full_like(travel, aside), last])
        return compose(turned, straight)


@dataclass(frozen=True, slots=True)
class StationaryMotion:
    """Ignores odometry and spreads the particles a little: the simplest model, for comparison."""

    sd_xy: float
    """[m] a step"""
    sd_theta: float
    """[rad] a step"""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Spread the particles where they are."""
        noise = rng.standard_normal(poses.shape) * (self.sd_xy, self.sd_xy, self.sd_theta)
        return compose(poses, noise)


def _either_way(turn: float) -> float:
    """The smaller turn, forward or in reverse: driving backwards is not a half turn."""
    return min(abs(turn), abs(wrap_angle(turn + math.pi)))


def _turn(angles: Array) -> Array:
    return np.column_stack([np.zeros((len(angles), 2)), angles])
