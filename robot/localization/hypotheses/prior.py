"""The given start pose as a prior, moved along by odometry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.kalman_filter import follow
from robot.localization.models.motion_models import MotionModel

LEAST_VARIANCE = np.diag(np.square([0.005, 0.005, 0.02]))
"""Least covariance of a given pose: nobody knows it better than this [m², m², rad²]."""


@dataclass(frozen=True, slots=True)
class Prior:
    """A pose with its covariance."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    log_weight: float = 0.0
    """Relative to the likeliest given pose."""

    def moved(self, step: Pose2, motion: MotionModel) -> Prior:
        """Return the prior after a step of odometry."""
        mean, noise = motion.moments(step)
        return Prior(*follow(self.pose, self.covariance, mean, noise), self.log_weight)

    def log_likelihood(self, pose: Pose2) -> float:
        """Return the log-likelihood of a pose, relative to the likeliest given pose."""
        offset = self.pose.offset_to(pose)
        return self.log_weight - 0.5 * float(
            offset @ np.linalg.solve(self.covariance + LEAST_VARIANCE, offset)
        )


def log_prior(priors: Sequence[Prior], pose: Pose2, log_kidnapped: float) -> float:
    """Return the prior log-likelihood of a found pose, relative to the followed one."""
    if not priors:
        return log_kidnapped
    likeliest = max(prior.log_likelihood(pose) for prior in priors)
    return float(np.logaddexp(likeliest, log_kidnapped))
