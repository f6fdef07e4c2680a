"""Spreading the copies that resampling makes, so that they do not die out at random."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.kernels.noise import noise_key
from robot.localization.kernels.spread_copies import spread_copies
from robot.localization.particles.clusters import Clusters


def regularize(
    poses: Array,
    clusters: Clusters,
    drawn: NDArray[np.int64],
    scale: float,
    rng: np.random.Generator,
) -> Array:
    """Copies (m, 3) of particles, spread as wide as their cluster's particles are apart.

    Copies of few particles die out at random along a direction that the scans say nothing of, as
    along a single wall, and the filter would be sure of what it never measured. The noise has the
    cluster's covariance times the squared bandwidth h = scale (4 / (n (d + 2)))^(1 / (d + 4)) with
    d = 3 (regularized particle filter; Musso, Oudjane and Le Gland 2001). With it the copies are
    drawn together by sqrt(1 - h^2) (shrinkage; West 1993), and what chance still left of a
    difference is taken away: copies of a cluster have its mean and its covariance, neither more
    nor less. So the width is right on average wherever no scan holds it. It still wanders, as the
    weights are chance there, too: told to 20 mm along a wall, 3 to 30 mm were left after 8 s.

    Args:
        poses: (n, 3) weighed particles.
        clusters: those that they are in.
        drawn: (m,) which particle each is a copy of.
        scale: 1 is best for a normal distribution, 0 is none.
        rng: the only source of chance.
    """
    if scale == 0:
        return poses[drawn]
    means, covariances = clusters.means, clusters.covariances
    return spread_copies(poses, clusters.labels, means, covariances, drawn, scale, noise_key(rng))
