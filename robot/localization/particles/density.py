"""How densely particles lie."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from robot.geometry import Array


@njit(cache=True, nogil=True)
def coarseness(
    weights: Array, covariances: Array, particles: int, ranges: Array
) -> tuple[float, int]:
    """How far the particles of a cluster lie apart, as a spread of ranges [m].

    A likelihood narrower than that falls between them and none is right; so while the cloud is
    wide, ranges are believed that much less. Angles count as what they move the end of a typical
    ray by. Also how many rays returned; with none nothing can be said, and it is 0.

    Args:
        weights: (k,) share of the weight in each cluster.
        covariances: (k, 3, 3) of the clusters [m, m, rad].
        particles: how many there are in all.
        ranges: (r,) lengths of the rays [m], +inf where nothing returned.
    """
    returned = ranges[np.isfinite(ranges)]
    if not len(returned):
        return 0.0, 0
    reach = np.median(returned)
    apart = 0.0
    for k in range(len(weights)):
        (xx, xy, xt), (_, yy, yt), (_, _, tt) = covariances[k]
        determinant = xx * (yy * tt - yt * yt) - xy * (xy * tt - yt * xt) + xt * (xy * yt - yy * xt)
        volume = math.sqrt(max(determinant, 0.0)) * reach
        apart += weights[k] * (volume / max(weights[k] * particles, 1.0)) ** (1 / 3)
    return float(apart), len(returned)
