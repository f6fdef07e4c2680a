"""Table 8.2: Monte Carlo localization."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.textbook.low_variance import low_variance_sampler
from robot.scan import Scan

SampleMotionModel = Callable[[Array, Pose2, np.random.Generator], Array]
"""Poses (n, 3) and a step by odometry to poses (n, 3)."""
MeasurementModel = Callable[[Array, Scan], Array]
"""Poses (n, 3) and a scan to log-likelihoods (n,)."""


def mcl(
    poses: Array,
    moved: Pose2,
    scan: Scan,
    sample_motion_model: SampleMotionModel,
    measurement_model: MeasurementModel,
    rng: np.random.Generator,
) -> Array:
    """Return the particles (n, 3) after one step and one scan.

    The program's filter (``robot.localization.particles``) adds to this: KLD sampling (Table 8.4),
    clusters, tempered likelihoods, and copies that are spread out.
    """
    poses = sample_motion_model(poses, moved, rng)

    log_likelihood = measurement_model(poses, scan)
    weights = np.exp(log_likelihood - log_likelihood.max())
    weights = weights / weights.sum()

    result: Array = poses[low_variance_sampler(weights, len(poses), rng)]
    return result
