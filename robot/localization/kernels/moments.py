"""Means and covariances of groups of particles, in one pass over them.

The moments are taken within each cell, about its first particle, and only then brought together:
there angles are plain numbers, and squares of small offsets lose no digits.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.kernels.headings import wrapped

MASS, SQUARES = 0, 1
"""Columns: sum of weights, and of their squares."""
FIRST, SECOND, ORIGIN = 2, 5, 11
"""Columns of the sums of offsets (3), of their products (6) and of what they are from (3)."""
COLUMNS = 14


@njit(cache=True, nogil=True, fastmath={"contract"}, error_model="numpy")
def add_moments(poses: Array, weights: Array, cell_of: NDArray[np.int64], cells: int) -> Array:
    """Moments (m, COLUMNS) of the particles (n, 3) in each cell."""
    moments = np.zeros((cells, COLUMNS))
    seen = 0
    for i in range(len(poses)):
        cell = cell_of[i]
        if cell == seen:  # cells are numbered as they come
            seen += 1
            moments[cell, ORIGIN : ORIGIN + 3] = poses[i]
        w = weights[i]
        x = poses[i, 0] - moments[cell, ORIGIN]
        y = poses[i, 1] - moments[cell, ORIGIN + 1]
        theta = wrapped(poses[i, 2] - moments[cell, ORIGIN + 2])
        moments[cell, MASS] += w
        moments[cell, SQUARES] += w * w
        moments[cell, FIRST] += w * x
        moments[cell, FIRST + 1] += w * y
        moments[cell, FIRST + 2] += w * theta
        moments[cell, SECOND] += w * x * x
        moments[cell, SECOND + 1] += w * x * y
        moments[cell, SECOND + 2] += w * x * theta
        moments[cell, SECOND + 3] += w * y * y
        moments[cell, SECOND + 4] += w * y * theta
        moments[cell, SECOND + 5] += w * theta * theta
    return moments


@njit(cache=True, nogil=True)
def describe(moments: Array, cluster_of: NDArray[np.int64], clusters: int) -> tuple[Array, Array]:
    """Means (k, 3) and covariances (k, 3, 3) of the first clusters; each cell (m,) is in one.

    The covariance is divided by 1 - sum w^2: the mean is the particles' own, and fewer of them
    lie closer to it than to the true one.
    """
    middle = _middles(moments, cluster_of, clusters)
    sums = np.zeros((clusters, COLUMNS))
    offset = np.empty(3)
    for cell in range(len(moments)):
        k = cluster_of[cell]
        if k >= clusters:
            continue
        offset[:2] = moments[cell, ORIGIN : ORIGIN + 2] - middle[k, :2]
        offset[2] = wrapped(moments[cell, ORIGIN + 2] - middle[k, 2])
        _add_about(sums[k], moments[cell], offset)
    means, covariances = np.empty((clusters, 3)), np.empty((clusters, 3, 3))
    for k in range(clusters):
        mass = sums[k, MASS]
        shift = sums[k, FIRST : FIRST + 3] / mass
        means[k] = middle[k] + shift
        means[k, 2] = wrapped(means[k, 2])
        independent = max(1 - sums[k, SQUARES] / mass**2, 0.5)
        column = SECOND
        for a in range(3):
            for b in range(a, 3):
                product = sums[k, column] / mass - shift[a] * shift[b]
                covariances[k, a, b] = covariances[k, b, a] = product / independent
                column += 1
    return means, covariances


@njit(cache=True, nogil=True)
def _middles(moments: Array, cluster_of: NDArray[np.int64], clusters: int) -> Array:
    """A pose (k, 3) amid each cluster to take offsets from; headings as unit vectors."""
    toward = np.zeros((clusters, 3))
    middle = np.zeros((clusters, 3))
    for cell in range(len(moments)):
        k, mass = cluster_of[cell], moments[cell, MASS]
        if k < clusters and mass > 0:
            theta = moments[cell, ORIGIN + 2] + moments[cell, FIRST + 2] / mass
            toward[k, 0] += mass * math.cos(theta)
            toward[k, 1] += mass * math.sin(theta)
            toward[k, 2] += mass
            middle[k, :2] += mass * moments[cell, ORIGIN : ORIGIN + 2]
    for k in range(clusters):
        middle[k, :2] /= toward[k, 2]
        middle[k, 2] = math.atan2(toward[k, 1], toward[k, 0])
    return middle


@njit(cache=True, nogil=True)
def _add_about(sums: Array, cell: Array, offset: Array) -> None:
    """Add a cell's moments to those about a pose from which its own are an offset (3,) away."""
    mass = cell[MASS]
    sums[MASS] += mass
    sums[SQUARES] += cell[SQUARES]
    column = SECOND
    for a in range(3):
        sums[FIRST + a] += cell[FIRST + a] + mass * offset[a]
        for b in range(a, 3):
            crossed = offset[a] * cell[FIRST + b] + offset[b] * cell[FIRST + a]
            sums[column] += cell[column] + crossed + mass * offset[a] * offset[b]
            column += 1
