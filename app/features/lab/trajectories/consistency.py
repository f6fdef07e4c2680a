"""Consistency of a filter's covariance: normalized estimation errors squared and their bounds.

Bar-Shalom, Li, Kirubarajan, Estimation with Applications to Tracking and Navigation, Wiley 2001,
section 5.4.2.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from robot.errors import BrickPoseError
from robot.geometry import Array

SINGULAR = 1e-12
"""A smaller eigenvalue of a correlation matrix counts as zero."""


class ConsistencyError(BrickPoseError, ValueError):
    """Errors and covariances that cannot be compared; the message says which."""


def nees(errors: Array, covariances: Array) -> Array:
    """Return the normalized estimation error squared (NEES) of each estimate.

    It is e' P^-1 e. If the covariance is consistent, it has the chi-square distribution of d
    degrees of freedom, with mean d.

    Args:
        errors: (n, d), truth minus estimate, angles by the shorter way [m, m, rad].
        covariances: (n, d, d), of the estimates.

    Returns:
        (n,), without unit.

    Raises:
        ConsistencyError: shapes differ, or a covariance is singular or invalid; names its index.
    """
    errors = np.asarray(errors, dtype=np.float64)
    covariances = np.asarray(covariances, dtype=np.float64)
    if errors.ndim != 2 or covariances.shape != (*errors.shape, errors.shape[1]):
        raise ConsistencyError(
            f"errors {errors.shape} and covariances {covariances.shape}; "
            "valid are shapes (n, d) and (n, d, d)"
        )
    finite = np.isfinite(errors).all(axis=1) & np.isfinite(covariances).all(axis=(1, 2))
    _check_each(~np.atleast_1d(finite), "not finite")
    deviations = np.sqrt(np.maximum(np.einsum("nii->ni", covariances), 0.0))
    _check_each((deviations <= 0).any(axis=1), "singular: a variance is not positive")
    # Correlations make values in metres and in radians comparable.
    scales = deviations[:, :, None] * deviations[:, None, :]
    correlations = covariances / scales
    _check_each(
        np.abs(correlations - correlations.transpose(0, 2, 1)).max(axis=(1, 2), initial=0) > 1e-6,
        "not symmetric",
    )
    smallest = np.linalg.eigvalsh(correlations).min(axis=1, initial=np.inf)
    _check_each(smallest <= SINGULAR, "singular: an error in some direction is certain to be zero")
    scaled = errors / deviations
    solved = np.linalg.solve(correlations, scaled[:, :, None])[:, :, 0]
    return np.asarray(np.sum(scaled * solved, axis=1), dtype=np.float64)


def anees_bounds(runs: int, dof: int = 3, level: float = 0.95) -> tuple[float, float]:
    """Return the bounds of the mean NEES of independent runs if the filter is consistent.

    The sum over N runs of d degrees of freedom each has the chi-square distribution of N d degrees
    of freedom; the bounds are its two-sided bounds divided by N. Above them, the filter is
    overconfident; below them, it is too cautious.

    Raises:
        ValueError: runs or degrees of freedom are less than 1, or level not between 0 and 1.
    """
    if runs < 1 or dof < 1 or not 0 < level < 1:
        raise ValueError(
            f"{runs} runs, {dof} degrees of freedom, level {level:g}; "
            "valid are 1 and more, 1 and more, between 0 and 1"
        )
    low, high = (float(chi2.ppf((1 + side * level) / 2, runs * dof)) / runs for side in (-1, 1))
    return low, high


def _check_each(wrong: NDArray[np.bool_], message: str) -> None:
    if wrong.any():
        raise ConsistencyError(f"covariance or error {int(np.argmax(wrong))} is {message}")
