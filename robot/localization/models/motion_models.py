"""Motion models: where may a robot be that was here and moved so?

A motion model is a frozen dataclass with ``sample`` and ``moments``; a student's own is the
same thing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2, mean_pose, pose_covariance
from robot.localization.models.differential_motion import STANDING_M, DifferentialMotion
from robot.localization.models.omni_motion import OmniMotion
from robot.localization.models.stationary_motion import StationaryMotion
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
