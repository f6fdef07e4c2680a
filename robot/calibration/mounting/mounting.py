"""A camera's mounting that was measured."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy.spatial.transform import Rotation

from robot.camera import Lens
from robot.description.unknowns import PRIORS, ROTATION, SHIFT
from robot.errors import BrickPoseError
from robot.estimation.fit_quality import FitQuality
from robot.geometry import Array

BODY_FROM_OPTICAL = Rotation.from_euler("xyz", (-math.pi / 2, 0, -math.pi / 2)).as_matrix()
"""The optical frame (z along the view) in the camera's body, whose x is along the view."""

UNITS = {
    "roll": ("degree", math.degrees(1)),
    "pitch": ("degree", math.degrees(1)),
    "yaw": ("degree", math.degrees(1)),
    "x": ("mm", 1e3),
    "y": ("mm", 1e3),
    "height": ("mm", 1e3),
}
"""What people read of a mounting: the unit, and how many of it are a radian or a metre."""
VAGUE = 0.5
"""What is known less than this share of what is known of a robot built by hand is not told."""
SMALL = (0.002, 0.5, 0.5)
"""Changes of the lens for derivatives: of the focal length by itself, of its centre [px]."""


class MountingError(BrickPoseError, ValueError):
    """A picture does not tell how the camera is mounted; the message says why."""


@dataclass(frozen=True, eq=False)
class Mounting:
    """Where the camera sits on the robot, and how exactly that is known."""

    robot_from_camera: Array = field(repr=False)
    """(4, 4) pose of the optical frame."""
    covariance: Array = field(repr=False)
    """(6, 6) of a rotation vector about the robot's axes [rad], and of the place [m]."""
    errors: Array = field(repr=False)
    """(n,) how far corners or edges lie off in the picture [px]."""
    quality: FitQuality
    """How well the mounting fits."""

    @property
    def rms(self) -> float:
        """Root mean square of the errors [px]."""
        return float(np.sqrt(np.mean(self.errors**2)))

    @cached_property
    def values(self) -> dict[str, float]:
        """Roll, pitch (down is positive) and yaw [rad], x, y and height [m]."""
        return dict(zip(UNITS, _read(self.robot_from_camera), strict=True))

    @cached_property
    def sd(self) -> dict[str, float]:
        """Standard deviations of ``values``."""
        slopes = derivatives(lambda step: _read(moved(self.robot_from_camera, step)), np.zeros(6))
        variances = np.diag(slopes @ self.covariance @ slopes.T)
        return dict(zip(UNITS, np.sqrt(variances).tolist(), strict=True))


@dataclass(frozen=True)
class LensDoubt:
    """How exactly a lens is known: standard deviations."""

    focal: float
    """Of the focal length, by itself."""
    centre: tuple[float, float] = (0.0, 0.0)
    """Of the principal point [px]."""

    def added(self, measure: Callable[[Lens], Mounting], lens: Lens) -> Mounting:
        """Return what is measured through a lens, with the lens's doubt in its covariance.

        Raises:
            MountingError: as ``measure``.
        """
        result = measure(lens)
        covariance = result.covariance.copy()
        fx, fy = lens.matrix[[0, 1], [0, 1]]
        steps = np.array([[fx, fy, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
        for sd, small, step in zip((self.focal, *self.centre), SMALL, steps, strict=True):
            if sd > 0:
                ends = [measure(_changed(lens, side * small * step)) for side in (-1, 1)]
                start, end = (mounting.robot_from_camera for mounting in ends)
                shift = step_between(start, end) * sd / (2 * small)
                covariance += np.outer(shift, shift)
        return replace(result, covariance=covariance)


def _changed(lens: Lens, step: Array) -> Lens:
    matrix = lens.matrix.copy()
    matrix[[0, 1, 0, 1], [0, 1, 2, 2]] += step
    return replace(lens, matrix=matrix)


def moved(robot_from_camera: Array, step: Array) -> Array:
    """Return a pose (4, 4) turned about the robot's axes and shifted along them by a step (6,)."""
    result = robot_from_camera.copy()
    result[:3, :3] = Rotation.from_rotvec(step[:3]).as_matrix() @ result[:3, :3]
    result[:3, 3] += step[3:]
    return result


def vague(covariance: Array) -> tuple[str, ...]:
    """Return what of a mounting (``UNITS``) is hardly known, by its covariance (6, 6)."""
    prior = np.concatenate([PRIORS[ROTATION], PRIORS[SHIFT]])
    unknown = np.sqrt(np.diag(covariance)) > VAGUE * prior
    return tuple(name for name, each in zip(UNITS, unknown, strict=True) if each)


def step_between(start: Array, end: Array) -> Array:
    """Return the step (6,) that ``moved`` takes from one pose (4, 4) to another."""
    turn = Rotation.from_matrix(end[:3, :3] @ start[:3, :3].T).as_rotvec()
    return np.concatenate([turn, end[:3, 3] - start[:3, 3]])


def derivatives(function: Callable[[Array], Array], place: Array, small: float = 1e-6) -> Array:
    """Return the derivatives (m, n) of a function of (n,) numbers, by differences."""
    columns = [
        (function(place + step) - function(place - step)) / (2 * small)
        for step in small * np.eye(len(place))
    ]
    return np.column_stack(columns)


def _read(robot_from_camera: Array) -> Array:
    turn = robot_from_camera[:3, :3] @ BODY_FROM_OPTICAL.T
    return np.concatenate([Rotation.from_matrix(turn).as_euler("xyz"), robot_from_camera[:3, 3]])
