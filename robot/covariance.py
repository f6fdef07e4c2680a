"""Covariances from outside: from commands, the configuration and files."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robot.geometry import Array

LARGEST = 1e4
"""[m^2, rad^2]; farther apart than the largest map is no spread."""


class CovarianceError(ValueError):
    """Numbers that are no covariance; the message says what would be."""


def covariance_from(numbers: Sequence[float]) -> Array:
    """Nine numbers by rows as a covariance (3, 3) [m, m, rad].

    What is negative only by rounding is made zero: a filter would carry it on.

    Raises:
        CovarianceError: they are not finite, not symmetric or not positive semi-definite.
    """
    if len(numbers) != 9:
        raise CovarianceError(f"covariance has {len(numbers)} numbers; valid are 9, by rows")
    matrix = np.array(numbers, dtype=np.float64).reshape(3, 3)
    if not (np.abs(matrix) <= LARGEST).all():
        raise CovarianceError(f"covariance has numbers beyond {LARGEST:g}; valid are smaller ones")
    # What was written with six digits is as good as symmetric.
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
    """A covariance (3, 3) as nine numbers."""
    rows: list[float] = covariance.ravel().tolist()
    return rows
