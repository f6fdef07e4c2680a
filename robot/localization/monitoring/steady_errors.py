"""Steady errors of a robot: how large they may be before any is seen; what they do to a pose."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from robot.compiling import compiled
from robot.covariance import outer
from robot.description.spec import RobotSpec
from robot.geometry import Array

MEMORY = 20.0
"""Scans and steps older than this hardly count for steady errors [s]."""
UNCALIBRATED = np.array([0.015, 0.03, 0.5, 0.04, 0.002, 0.002, 0.008])
"""Of wheels, clock and place of the camera, in the order of ``odometry_check.ERRORS`` [s, -, rad/m,
-, m, m, rad]. Half, with half of CAREFUL_MOUNT: misleading in 5.0 % of pictures, not 0.6; twice: in
none, 38.0 % certain, not 38.3, and fewer causes are named (``--few``)."""
CHANGED = np.array([0.002, 0.005, 0.1, 0.01, 0.0003, 0.0003, 0.001])
"""How far a calibrated robot may have changed since: tyres wear, cameras are late by turns."""
CAREFUL_MOUNT = np.array([math.radians(0.3), math.radians(0.3), 0.0015])
"""Of the camera's pitch and roll [rad], if it was mounted with care, and of the map's scale."""
SAME_MOUNT = math.radians(0.03)
"""How far a mast may have bent since its calibration [rad]."""


@dataclass(frozen=True, slots=True, eq=False)
class SteadyErrors:
    """Standard deviations of errors that stay the same over a drive."""

    odometry: Array = field(default_factory=UNCALIBRATED.copy, repr=False)
    """(7,) in the order of ``odometry_check.ERRORS``."""
    mounting: Array = field(default_factory=CAREFUL_MOUNT.copy, repr=False)
    """(3,) of pitch, roll [rad] and the map's scale [-]."""
    measured: Array = field(default_factory=lambda: np.zeros(3), repr=False)
    """(3,) of the camera's place and yaw on the robot, as a calibration says [m, m, rad]; zero if
    it was not calibrated, as nobody says then how wrong the drawing is. The pose errs as they do,
    and no scan tells."""

    @classmethod
    def of(cls, spec: RobotSpec | None) -> SteadyErrors:
        """Return those of a robot; None, and a robot that nobody measured, is as people build."""
        if spec is None or spec.measured_sd is None:
            return cls()
        return cls.calibrated(spec.measured_sd, spec.track)

    @classmethod
    def calibrated(cls, sd: Array, track: float) -> SteadyErrors:
        """Return what a calibration leaves open.

        Args:
            sd: (11,) standard deviations of what was measured, as in a robot's profile.
            track: distance between the wheels [m].
        """
        roll, pitch, yaw, x, y, _, _, delay, left, right, separation = sd.tolist()
        radii = math.hypot(left, right)
        left_open = np.array([delay, radii / 2, radii / track, separation, x, y, yaw])
        # A drive that told nothing of some of them leaves them as wide as they were.
        odometry = np.minimum(np.hypot(left_open, CHANGED), UNCALIBRATED)
        tilt = np.minimum(np.hypot([pitch, roll], SAME_MOUNT), CAREFUL_MOUNT[:2])
        measured = np.minimum([x, y, yaw], UNCALIBRATED[4:])
        return cls(odometry, np.append(tilt, CAREFUL_MOUNT[2]), measured)


@compiled()
def pose_errors(
    heading: float,
    v: float,
    omega: float,
    values: Array,
    covariance: Array,
    lateness: float,
    caused: Array,
    caused_spread: Array,
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
    beyond = np.diag(_beyond(mean, spread) ** 2)
    if lateness != 0:
        # The corrected lateness is not known better than this.
        beyond += covariance[0, 0] * outer(offset[:, 0], offset[:, 0])
    known = rotation @ beyond @ back + np.diag(_beyond(caused, caused_spread) ** 2)
    unknown = rotation @ (outer(mean, mean) + spread) @ back
    unknown += outer(caused, caused) + caused_spread
    return known, unknown


@compiled()
def _beyond(mean: Array, covariance: Array) -> Array:
    """Return the significant part of means (3,): above one spread, less half of it; else zero."""
    result = np.zeros(3)
    for i in range(3):
        size, sd = abs(mean[i]), np.sqrt(covariance[i, i])
        if size > sd:
            result[i] = size - 0.5 * sd
    return result
