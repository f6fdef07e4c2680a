"""Spreads copies of particles so that each cluster stays as wide as it was.

``resampling.regularize`` says why.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.covariance import outer
from robot.geometry import Array
from robot.localization.kernels.sampling import normal_rows
from robot.localization.kernels.steps import wrapped

Noise = NDArray[np.float32]

FEW = 10
"""The covariance of fewer copies says nothing, so they are not stretched to fit it."""
MOST_STRETCH = 2.0
"""Copies that would have to be stretched more than this are left as they are."""


@compiled()
def spread_copies(
    poses: Array,
    labels: NDArray[np.int64],
    means: Array,
    covariances: Array,
    drawn: NDArray[np.int64],
    scale: float,
    key: int,
) -> Array:
    """Return noisy copies (m, 3) of the drawn particles; ``key`` is that of ``normal_rows``."""
    columns, ends = _by_cluster(poses, labels, drawn, len(means))
    noise = normal_rows(key, 3, len(drawn))
    start = 0
    for k in range(len(means)):
        end = ends[k]
        x, y, theta = columns[0, start:end], columns[1, start:end], columns[2, start:end]
        chance = noise[0, start:end], noise[1, start:end], noise[2, start:end]
        start, count = end, len(x)
        if count > 1:
            bandwidth = min(scale * (4 / (5 * count)) ** (1 / 7), 1.0)
            middle, current = _add_noise(x, y, theta, means[k], covariances[k], bandwidth, chance)
            stretch = _as_wide(current, covariances[k])
            if count < FEW or np.trace(stretch) > 3 * MOST_STRETCH:
                middle, stretch = np.zeros(3), np.eye(3)
            _place(x, y, theta, means[k], middle, stretch)
    return np.ascontiguousarray(columns.T)


@compiled()
def _by_cluster(
    poses: Array, labels: NDArray[np.int64], drawn: NDArray[np.int64], described: int
) -> tuple[Array, NDArray[np.int64]]:
    """Return the copies (3, m), sorted by cluster, and the end of each cluster in them.

    Copies of clusters that are not described come last. In this order the compiler can work on
    eight copies at a time, and spreading takes a third less time.
    """
    ends = np.zeros(described + 1, dtype=np.int64)
    for i in drawn:
        ends[min(labels[i], described)] += 1
    ends = np.cumsum(ends)
    free = np.zeros(described + 1, dtype=np.int64)
    for k in range(described):
        free[k + 1] = ends[k]
    columns = np.empty((3, len(drawn)))
    for i in drawn:
        k = min(labels[i], described)
        columns[0, free[k]], columns[1, free[k]] = poses[i, 0], poses[i, 1]
        columns[2, free[k]] = poses[i, 2]
        free[k] += 1
    return columns, ends


@compiled(fastmath={"contract", "reassoc", "nsz"}, error_model="numpy")
def _add_noise(
    all_x: Array,
    all_y: Array,
    all_theta: Array,
    mean: Array,
    covariance: Array,
    bandwidth: float,
    noise: tuple[Noise, Noise, Noise],
) -> tuple[Array, Array]:
    """Replace poses by noisy offsets from a mean; return the offsets' own mean and covariance."""
    keep, root = math.sqrt(1 - bandwidth**2), bandwidth * lower_root(covariance)
    xx, yx, yy = root[0, 0], root[1, 0], root[1, 1]
    tx, ty, tt = root[2, 0], root[2, 1], root[2, 2]
    mean_x, mean_y, mean_theta = mean
    a, b, c = noise
    count = len(all_x)
    s0 = s1 = s2 = s00 = s01 = s02 = s11 = s12 = s22 = 0.0
    for i in range(count):
        x = keep * (all_x[i] - mean_x) + xx * a[i]
        y = keep * (all_y[i] - mean_y) + yx * a[i] + yy * b[i]
        theta = keep * wrapped(all_theta[i] - mean_theta) + tx * a[i] + ty * b[i] + tt * c[i]
        all_x[i], all_y[i], all_theta[i] = x, y, theta
        s0, s1, s2 = s0 + x, s1 + y, s2 + theta
        s00, s01, s02 = s00 + x * x, s01 + x * y, s02 + x * theta
        s11, s12, s22 = s11 + y * y, s12 + y * theta, s22 + theta * theta
    middle = np.array([s0, s1, s2]) / count
    squares = np.array([[s00, s01, s02], [s01, s11, s12], [s02, s12, s22]])
    return middle, (squares - count * outer(middle, middle)) / (count - 1)


@compiled(fastmath={"contract", "reassoc", "nsz"}, error_model="numpy")
def _place(
    all_x: Array, all_y: Array, all_theta: Array, mean: Array, middle: Array, stretch: Array
) -> None:
    """Replace offsets by poses about a mean, stretched about the offsets' own middle."""
    xx, yx, yy = stretch[0, 0], stretch[1, 0], stretch[1, 1]
    tx, ty, tt = stretch[2, 0], stretch[2, 1], stretch[2, 2]
    mean_x, mean_y, mean_theta = mean
    middle_x, middle_y, middle_theta = middle
    for i in range(len(all_x)):
        x, y, theta = all_x[i] - middle_x, all_y[i] - middle_y, all_theta[i] - middle_theta
        all_x[i] = mean_x + xx * x
        all_y[i] = mean_y + yx * x + yy * y
        all_theta[i] = wrapped(mean_theta + tx * x + ty * y + tt * theta)


@compiled()
def _as_wide(current: Array, covariance: Array) -> Array:
    """Return the matrix (3, 3) that gives offsets with the current covariance the wanted one.

    It is the lower root of the wanted covariance times the inverse of the current one's.
    """
    have, want = lower_root(current), lower_root(covariance)
    stretch = np.eye(3)
    for a in range(3):
        for b in range(a, -1, -1):
            rest = want[a, b]
            for c in range(b + 1, a + 1):
                rest -= stretch[a, c] * have[c, b]
            if have[b, b] > 0:
                stretch[a, b] = rest / have[b, b]
    return stretch


@compiled()
def lower_root(covariance: Array) -> Array:
    """Return the Cholesky factor (3, 3) of a covariance, lower triangular.

    A direction without any spread has a column of zeros.
    """
    root = np.zeros((3, 3))
    for a in range(3):
        for b in range(a + 1):
            rest = covariance[a, b]
            for c in range(b):
                rest -= root[a, c] * root[b, c]
            if a == b:
                # A remainder this small is only rounding.
                root[a, a] = math.sqrt(rest) if rest > 1e-12 * covariance[a, a] else 0.0
            elif root[b, b] > 0:
                root[a, b] = rest / root[b, b]
    return root
