"""Planar poses and velocities; all heading trigonometry of the project.

Frames (REP-103: x forward, y left, z up; angles from +x, anticlockwise; metres and radians):

========  =============================================================================
map       the field; its origin is the drawing's origin
odom      where odometry started; it drifts against the map
robot     on the floor below the middle of the axle (REP-120's ``base_footprint``)
camera    optical frame: x right, y down, z along the view
========  =============================================================================

``a_from_b`` transforms coordinates in b to coordinates in a. So in a chain
``map_from_odom @ odom_from_robot``, neighbouring frames must have the same name.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TURN = 2 * math.pi
_set = object.__setattr__


@overload
def wrap_angle(angle: float) -> float: ...
@overload
def wrap_angle(angle: Array) -> Array: ...
def wrap_angle(angle: float | Array) -> float | Array:
    """Bring an angle [rad] into [-pi, pi)."""
    if isinstance(angle, np.ndarray):
        wrapped = np.mod(angle + math.pi, 2 * math.pi) - math.pi
        # mod rounds a tiny negative angle up to the full turn.
        return np.where(wrapped >= math.pi, -math.pi, wrapped)
    wrapped_angle = (angle + math.pi) % (2 * math.pi) - math.pi
    return -math.pi if wrapped_angle >= math.pi else wrapped_angle


@dataclass(frozen=True, slots=True, init=False)
class Pose2:
    """A planar pose: position x, y [m] and heading theta [rad] in [-pi, pi)."""

    x: float
    y: float
    theta: float

    def __init__(self, x: float = 0.0, y: float = 0.0, theta: float = 0.0) -> None:
        # Written out: a lap makes 23,000 poses, and the generated one with a wrapping afterwards
        # takes half as long again (4.0 instead of 2.8 us).
        wrapped = (theta + math.pi) % TURN - math.pi
        _set(self, "x", x)
        _set(self, "y", y)
        _set(self, "theta", -math.pi if wrapped >= math.pi else wrapped)

    def __matmul__(self, other: Pose2) -> Pose2:
        """Chain two poses: ``a_from_b @ b_from_c`` is ``a_from_c``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2(
            self.x + c * other.x - s * other.y,
            self.y + s * other.x + c * other.y,
            self.theta + other.theta,
        )

    def inverse(self) -> Pose2:
        """Swap the two frames: ``a_from_b`` becomes ``b_from_a``."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        return Pose2(-c * self.x - s * self.y, s * self.x - c * self.y, -self.theta)

    def apply(self, points: Array) -> Array:
        """Transform points (n, 2) [m] from the inner frame to the outer one."""
        c, s = math.cos(self.theta), math.sin(self.theta)
        outer: Array = points @ np.array([[c, s], [-s, c]]) + (self.x, self.y)
        return outer

    def distance_to(self, other: Pose2) -> float:
        """Return the distance between the two positions [m]."""
        return math.hypot(self.x - other.x, self.y - other.y)

    def turn_to(self, other: Pose2) -> float:
        """Return the angle from this heading to the other [rad], in [-pi, pi)."""
        return wrap_angle(other.theta - self.theta)

    def offset_to(self, other: Pose2) -> Array:
        """Return the difference (3,) [m, m, rad] to the other pose, by the shorter turn."""
        return np.array([other.x - self.x, other.y - self.y, self.turn_to(other)])

    def is_finite(self) -> bool:
        """Whether all three numbers are finite."""
        return math.isfinite(self.x) and math.isfinite(self.y) and math.isfinite(self.theta)

    def to_array(self) -> Array:
        """Return the pose as an array (3,): x, y, theta."""
        return np.array([self.x, self.y, self.theta])

    @classmethod
    def from_array(cls, values: Array) -> Pose2:
        """Make a pose from an array (3,): x, y, theta."""
        return cls(float(values[0]), float(values[1]), float(values[2]))


@dataclass(frozen=True, slots=True)
class Twist2:
    """A planar velocity in the robot frame: v [m/s] forward and omega [rad/s] anticlockwise."""

    v: float = 0.0
    omega: float = 0.0

    def integrate(self, duration: float) -> Pose2:
        """Return the end pose, in the start frame, of a robot that keeps this twist for a time [s].

        The path is an arc of a circle (Probabilistic Robotics, Table 5.3, without the noise).
        """
        turn = self.omega * duration
        distance = self.v * duration
        # sin(t)/t and (1 - cos(t))/t; near zero, their Taylor series.
        if abs(turn) < 1e-4:
            along, aside = 1 - turn * turn / 6, turn / 2
        else:
            along, aside = math.sin(turn) / turn, (1 - math.cos(turn)) / turn
        return Pose2(distance * along, distance * aside, turn)


def interpolate(start: Pose2, end: Pose2, fraction: float) -> Pose2:
    """Return the pose a fraction of the way between two, by the shorter turn."""
    return Pose2(
        start.x + fraction * (end.x - start.x),
        start.y + fraction * (end.y - start.y),
        start.theta + fraction * start.turn_to(end),
    )


def heading_vectors(angles: Array) -> Array:
    """Return unit vectors (n, 2) that point along angles (n,) [rad]."""
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def heading_angles(vectors: Array) -> Array:
    """Return the angles (n,) [rad] of vectors (n, 2)."""
    return np.arctan2(vectors[..., 1], vectors[..., 0])


def compose(poses: Array, moved: Array) -> Array:
    """Return ``poses @ moved`` (n, 3) for arrays of poses (n, 3) and motions (n, 3) or (3,)."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx, dy, turn = moved[..., 0], moved[..., 1], moved[..., 2]
    return np.stack(
        [
            poses[:, 0] + c * dx - s * dy,
            poses[:, 1] + s * dx + c * dy,
            wrap_angle(poses[:, 2] + turn),
        ],
        axis=1,
    )


def mean_pose(poses: Array, weights: Array) -> Pose2:
    """Return the weighted mean of poses (n, 3); headings are averaged as unit vectors."""
    total = weights.sum()
    x, y = weights @ poses[:, :2] / total
    toward_x, toward_y = weights @ heading_vectors(poses[:, 2])
    return Pose2(float(x), float(y), math.atan2(toward_y, toward_x))


def pose_covariance(poses: Array, weights: Array, mean: Pose2) -> Array:
    """Return the weighted covariance (3, 3) [m, m, rad] of poses (n, 3) about their mean."""
    offsets = poses - mean.to_array()
    offsets[:, 2] = wrap_angle(offsets[:, 2])
    covariance: Array = (offsets * (weights / weights.sum())[:, None]).T @ offsets
    return covariance


def turned_covariance(covariance: Array, turn: float) -> Array:
    """Return a covariance (3, 3) of x, y, theta, seen from axes turned back by ``turn`` [rad]."""
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned: Array = rotation @ covariance @ rotation.T
    return turned


def covariance_root(covariance: Array) -> Array:
    """Return a root (3, 3) of a covariance, which may be singular.

    The product of the root with its transpose is the covariance.
    """
    values, axes = np.linalg.eigh(covariance)
    root: Array = axes * np.sqrt(np.maximum(values, 0.0))
    return root
