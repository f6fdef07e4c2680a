"""Covariances that come from outside, and compiled operations on small matrices."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from robot.compiling import compiled
from robot.errors import BrickPoseError
from robot.geometry import Array

LARGEST = 1e4
"""Largest number in a covariance [m^2, rad^2]; a wider spread would exceed the largest map."""


class CovarianceError(BrickPoseError, ValueError):
    """Numbers that are not a valid covariance; the message says what is valid."""


def covariance_from(numbers: Sequence[float]) -> Array:
    """Return nine numbers, given by rows, as a covariance (3, 3) [m, m, rad].

    Eigenvalues that are negative only by rounding become zero, because a filter would propagate
    them.

    Raises:
        CovarianceError: the numbers are not nine, or they are not finite, too large, not symmetric
            or not positive semi-definite.
    """
    if len(numbers) != 9:
        raise CovarianceError(f"covariance has {len(numbers)} numbers; valid are 9, by rows")
    matrix = np.array(numbers, dtype=np.float64).reshape(3, 3)
    if not (np.abs(matrix) <= LARGEST).all():
        raise CovarianceError(f"covariance has numbers beyond {LARGEST:g}; valid are smaller ones")
    # Numbers that were written with six digits count as symmetric.
    if not np.allclose(matrix, matrix.T, rtol=1e-5, atol=1e-12):
        raise CovarianceError("covariance is not symmetric; valid has c[i][j] = c[j][i]")
    even: Array = (matrix + matrix.T) / 2
    values, axes = np.linalg.eigh(even)
    if values[0] < -1e-6 * max(values[-1], 1e-9):
        raise CovarianceError(
            f"covariance is not positive semi-definite: an eigenvalue is {values[0]:.3g}"
        )
    if values[0] >= 0:
        return even
    mended: Array = (axes * np.maximum(values, 0)) @ axes.T
    return (mended + mended.T) / 2


def by_rows(covariance: Array) -> list[float]:
    """Return a covariance (3, 3) as nine numbers, by rows."""
    rows: list[float] = covariance.ravel().tolist()
    return rows


@compiled()
def inverse(matrix: Array) -> Array:
    """Of a regular matrix (n, n)."""
    return np.linalg.inv(matrix).astype(np.float64)


@compiled()
def solved(matrix: Array, right: Array) -> Array:
    """x of matrix (n, n) @ x = right (n, m)."""
    return np.linalg.solve(matrix, right).astype(np.float64)


@compiled()
def outer(a: Array, b: Array) -> Array:
    """Return the product (n, m) of each number of a (n,) with each of b (m,)."""
    result = np.empty((len(a), len(b)))
    for i in range(len(a)):
        for j in range(len(b)):
            result[i, j] = a[i] * b[j]
    return result


def widest(covariance: Array) -> float:
    """Standard deviation along the longer axis of the place in a covariance (2 or more)."""
    a, b, c = float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])
    return math.sqrt(max(0.5 * (a + c) + math.hypot(0.5 * (a - c), b), 0.0))
