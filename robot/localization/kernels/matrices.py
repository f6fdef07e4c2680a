"""Compiled operations on small matrices: to call numpy takes ten times as long as the work."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from robot.geometry import Array


@njit(cache=True, nogil=True)
def inverse(matrix: Array) -> Array:
    """Of a regular matrix (n, n)."""
    return np.linalg.inv(matrix).astype(np.float64)


@njit(cache=True, nogil=True)
def solved(matrix: Array, right: Array) -> Array:
    """x of matrix (n, n) @ x = right (n, m)."""
    return np.linalg.solve(matrix, right).astype(np.float64)


def widest(covariance: Array) -> float:
    """Standard deviation along the longer axis of the place in a covariance (2 or more)."""
    a, b, c = float(covariance[0, 0]), float(covariance[0, 1]), float(covariance[1, 1])
    return math.sqrt(max(0.5 * (a + c) + math.hypot(0.5 * (a - c), b), 0.0))
