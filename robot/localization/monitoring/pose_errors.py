"""Effect of steady errors of clock, wheels, camera and map on a pose."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from robot.geometry import Array


@njit(cache=True, nogil=True)
def pose_errors(
    heading: float,
    v: float,
    omega: float,
    values: Array,
    covariance: Array,
    lateness: float,
    caused: Array,
    caused_spread: Array,
    wiggle: Array,
) -> tuple[Array, Array]:
    """Return how far a pose may be off by steady errors: found ones, and ones not excluded yet.

    Args:
        heading: heading of the pose [rad].
        v: velocity of the robot [m/s].
        omega: turning velocity of the robot [rad/s].
        values: errors of odometry (7,).
        covariance: covariance of these errors (7, 7).
        lateness: lateness that is already corrected [s].
        caused: pose error by camera and map (3,), along the map's axes.
        caused_spread: covariance of that pose error (3, 3).
        wiggle: covariance of the unexplained rest of steps (3, 3), along the robot's axes.

    Returns:
        Two covariances (3, 3) [m, m, rad], along the map's axes.
    """
    # The pose is that of the robot tau earlier, shifted by a constant offset.
    offset = np.zeros((3, 7))
    offset[0, 0], offset[2, 0] = -v, -omega
    offset[:, 4:] = np.eye(3)
    left = values.copy()
    left[0] -= lateness
    mean = offset @ left
    spread = offset @ covariance @ np.ascontiguousarray(offset.T)
    c, s = math.cos(heading), math.sin(heading)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    back = np.ascontiguousarray(rotation.T)
    beyond = np.diag(_beyond(mean, spread) ** 2) + wiggle
    if lateness != 0:
        # The corrected lateness is not known better than this.
        beyond += covariance[0, 0] * np.outer(offset[:, 0], offset[:, 0])
    known = rotation @ beyond @ back + np.diag(_beyond(caused, caused_spread) ** 2)
    unknown = rotation @ (np.outer(mean, mean) + spread) @ back
    unknown += np.outer(caused, caused) + caused_spread
    return known, unknown


@njit(cache=True, nogil=True)
def _beyond(mean: Array, covariance: Array) -> Array:
    """Return the significant part of means (3,): above one spread, less half of it; else zero."""
    sd = np.sqrt(np.diag(covariance))
    return np.where(np.abs(mean) > sd, np.abs(mean) - 0.5 * sd, 0.0)
