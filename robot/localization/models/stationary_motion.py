"""A motion model that knows nothing of motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.models.turn_and_go import Legs, sample_legs


@dataclass(frozen=True, slots=True)
class StationaryMotion:
    """Ignores odometry and spreads the particles a little: the simplest model, for comparison.

    Also what is left for a robot without wheel sensors that moves slowly.
    """

    sd_xy: float
    """[m] a step"""
    sd_theta: float
    """[rad] a step"""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Spread the particles where they are."""
        spread = Legs(0.0, self.sd_xy, self.sd_xy, self.sd_theta)
        return sample_legs(poses, Legs(0.0, 0.0, 0.0, 0.0), spread, rng)

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance (3, 3) [m, m, rad] of where the step ends: where it starts."""
        return Pose2(), np.diag(np.square([self.sd_xy, self.sd_xy, self.sd_theta]))
