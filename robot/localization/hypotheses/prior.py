"""What was told of the pose at the start, carried along by odometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.kalman_filter import follow
from robot.localization.models.motion_models import MotionModel

LEAST_VARIANCE = np.diag(np.square([0.005, 0.005, 0.02]))
"""Nobody tells a pose better than this [m², m², rad²]."""


@dataclass(frozen=True, slots=True)
class Prior:
    """A pose with its covariance."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    log_weight: float = 0.0
    """Relative to the likeliest that was told."""

    def moved(self, step: Pose2, motion: MotionModel) -> Prior:
        """After a step by odometry."""
        mean, noise = motion.moments(step)
        return Prior(*follow(self.pose, self.covariance, mean, noise), self.log_weight)

    def log_likelihood(self, pose: Pose2) -> float:
        """Of a pose, relative to the likeliest that was told."""
        offset = self.pose.offset_to(pose)
        return self.log_weight - 0.5 * float(
            offset @ np.linalg.solve(self.covariance + LEAST_VARIANCE, offset)
        )


def log_prior(priors: Sequence[Prior], pose: Pose2, log_kidnapped: float) -> float:
    """How likely a pose was before it was found, beside the one that is followed."""
    if not priors:
        return log_kidnapped
    likeliest = max(prior.log_likelihood(pose) for prior in priors)
    return float(np.logaddexp(likeliest, log_kidnapped))
