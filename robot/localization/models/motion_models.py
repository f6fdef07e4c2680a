"""Motion models: where may a robot be that was here and moved so?

A motion model is a frozen dataclass with ``sample`` and ``moments``; a student's own is the
same thing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2, compose, mean_pose, pose_covariance, wrap_angle
from robot.localization.models.odometry_motion import (
    STANDING_M,
    DifferentialMotion,
    OmniMotion,
    StationaryMotion,
)
from robot.localization.models.velocity_motion import VelocityMotion

__all__ = [
    "STANDING_M",
    "DifferentialMotion",
    "MotionModel",
    "OmniMotion",
    "StationaryMotion",
    "VelocityMotion",
    "sampled_moments",
]


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

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance (3, 3) [m, m, rad] of where a step ends, seen from its start.

        For filters without particles: those of ``sample`` to first order, in closed form; a model
        without one may return ``sampled_moments``.

        Args:
            moved: the step by odometry, seen from its start.
        """
        ...


Sample = Callable[[Array, Pose2, np.random.Generator], Array]


def sampled_moments(sample: Sample, moved: Pose2, count: int = 1000) -> tuple[Pose2, Array]:
    """Mean and covariance (3, 3) [m, m, rad] of where a step ends, seen from its start, by draws.

    Always the same draws, so the same step has the same covariance.
    """
    ends = sample(np.zeros((count, 3)), moved, np.random.default_rng(0))
    even = np.full(count, 1.0 / count)
    mean = mean_pose(ends, even)
    return mean, pose_covariance(ends, even, mean)


@dataclass(frozen=True, slots=True)
class LoosenedMotion:
    """Another model, with all its standard deviations so many times wider."""

    model: MotionModel
    factor: float

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw where each particle (n, 3) went."""
        drawn = self.model.sample(poses, moved, rng)
        mean = compose(poses, self.model.moments(moved)[0].to_array())
        away = drawn - mean
        away[:, 2] = wrap_angle(away[:, 2])
        loosened: Array = mean + self.factor * away
        loosened[:, 2] = wrap_angle(loosened[:, 2])
        return loosened

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance (3, 3) of where a step ends."""
        mean, covariance = self.model.moments(moved)
        return mean, covariance * self.factor**2


def loosened(model: MotionModel, factor: float) -> MotionModel:
    """The model itself, if steps err as usual."""
    return model if factor == 1.0 else LoosenedMotion(model, factor)
