"""PlaceTracker: follows a robot from a known place, by scans laid on some of the tape."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot import ray_columns as column
from robot.compiling import compiled
from robot.covariance import inverse, widest
from robot.fields.edge_index import EdgeIndex, index_edges
from robot.fields.ray_casting import cast_toward
from robot.geometry import Array, Pose2
from robot.localization.scan_matching import ScanMatcher, fit_rays

REACH = 0.6
"""Returns farther away are not exact enough [m]."""
RANGE_SD, SLOPE = 0.002, 25.0
"""Standard deviation of a range [m], and how it grows with the range [1/m²]."""
GATE = 0.05
"""A return farther from where it should be belongs to other tape [m]."""
STILL_SD = 3e-5, 1e-4
"""What odometry of a robot that stands errs by, a step's standard deviation [m], [rad]."""
LEAST_SD = 3e-4
"""Scans one after the other see the same errors of the drawing, so a place is not known better [m],
[rad]."""
UNKNOWN_SD = 1.0
"""Of a place of which nothing is known [m], [rad]."""


class StepErrors(NamedTuple):
    """What odometry errs by, a step's standard deviation, besides that of a robot that stands."""

    ahead: float
    """Share of a way, along the robot."""
    aside: float
    """Across it."""
    turn: float
    """Share of a turn."""
    turn_by_way: float
    """A turn by the way [rad/m]."""


USUAL_STEPS = StepErrors(ahead=0.085, aside=0.03, turn=0.085, turn_by_way=0.06)
"""Of wheels that slip now and then."""


class Expected(NamedTuple):
    """What rays should see."""

    ranges: Array
    """(n,) [m]; inf where they meet no tape."""
    edges: NDArray[np.int64]
    """(n,) which edge they meet; -1 for none."""


class PlaceTracker:
    """A Kalman filter of one place: odometry predicts, scans correct."""

    def __init__(self, edges: Array, pose: Pose2, covariance: Array) -> None:
        """Begin at a pose with a covariance (3, 3) [m, m, rad]; edges (n, 4) [m] may be some."""
        self._matcher = ScanMatcher(index_edges(edges), REACH, RANGE_SD, GATE, SLOPE)
        self.pose = pose
        self.covariance = covariance
        self.by_scans = UNKNOWN_SD**2 * np.eye(3)
        """The covariance, as if nothing had been known at the beginning."""
        self.leap = 0.0
        """The farthest that a scan has moved the place, in standard deviations of odometry."""

    def step(self, moved: Pose2, rays: Array) -> None:
        """Follow a step of odometry, and lay rays (n, 9) on the tape."""
        self._predict(moved)
        known = inverse(self.covariance)
        before = self.pose
        pose, information, _ = fit_rays(before.to_array(), known, rays, self._matcher)
        self.pose = Pose2(*pose.tolist())
        leap = np.array([self.pose.x - before.x, self.pose.y - before.y, before.turn_to(self.pose)])
        self.leap = max(self.leap, math.sqrt(float(leap @ known @ leap)))
        gained = information - known
        self.covariance = _corrected(self.covariance, gained)
        self.by_scans = _corrected(self.by_scans, gained)

    @property
    def width(self) -> float:
        """Largest standard deviation of the place [m]."""
        return widest(self.covariance)

    def _predict(self, moved: Pose2) -> None:
        motion, added = step_model(self.pose, moved, USUAL_STEPS)
        self.covariance = motion @ self.covariance @ motion.T + added
        self.by_scans = motion @ self.by_scans @ motion.T + added
        self.pose = self.pose @ moved

    def expected(self, rays: Array, reach: float = REACH) -> Expected:
        """Return what rays (n, 9) should see of its edges from its pose within their reach [m]."""
        return expect(self.pose, rays, self._matcher.edge_index, reach)


def step_model(pose: Pose2, moved: Pose2, errors: StepErrors) -> tuple[Array, Array]:
    """Return how a step from a pose moves errors of the pose (3, 3), and what it adds (3, 3)."""
    way = math.hypot(moved.x, moved.y)
    cos, sin = math.cos(pose.theta), math.sin(pose.theta)
    dx, dy = cos * moved.x - sin * moved.y, sin * moved.x + cos * moved.y
    motion = np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])
    turn = errors.turn * abs(moved.theta) + errors.turn_by_way * way + STILL_SD[1]
    sds = np.array([errors.ahead * way + STILL_SD[0], errors.aside * way + STILL_SD[0], turn])
    to_map = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) * sds
    return motion, to_map @ to_map.T


def _corrected(covariance: Array, gained: Array) -> Array:
    """Return a covariance (3, 3) after a scan with so much information (3, 3)."""
    result: Array = inverse(inverse(covariance) + gained) + LEAST_SD**2 * np.eye(3)
    return result


def expect(pose: Pose2, rays: Array, index: EdgeIndex, reach: float = REACH) -> Expected:
    """Return what rays (n, 9) should see from a pose within their reach [m]."""
    ranges, edges = np.empty(len(rays)), np.empty(len(rays), dtype=np.int64)
    _expect(pose.to_array(), rays, index, reach, ranges, edges)
    return Expected(ranges, edges)


@compiled()
def _expect(
    pose: Array,
    rays: Array,
    index: EdgeIndex,
    reach: float,
    ranges: Array,
    edges: NDArray[np.int64],
) -> None:
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    for i in range(len(rays)):
        x, y = rays[i, column.X], rays[i, column.Y]
        heading = pose[2] + rays[i, column.DIRECTION]
        ranges[i], edges[i] = cast_toward(
            pose[0] + cos * x - sin * y,
            pose[1] + sin * x + cos * y,
            math.cos(heading),
            math.sin(heading),
            index,
            reach,
        )
