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
from robot.misplaced_tape.odometry_errors import (
    LASTING,
    POSE,
    WHEELS,
    corrected_step,
    joint_errors,
    predict,
)

REACH = 0.6
"""Returns farther away are not exact enough [m]."""
RANGE_SD, SLOPE = 0.002, 25.0
"""Standard deviation of a range [m], and how it grows with the range [1/m²]."""
GATE = 0.05
"""A return farther from where it should be belongs to other tape [m]."""
KNOWN_M, BESIDE_SDS, FARTHEST_BESIDE, LEVER = 0.004, 2.0, 0.05, 0.25
"""A place is looked at from so many standard deviations beside as well, at most so far [m], unless
its largest one is less [m]; a turn moves what is seen by so much [m/rad]."""
UNKNOWN_SD = 1.0
"""Of a place of which nothing is known [m], [rad]."""


class Expected(NamedTuple):
    """What rays should see."""

    ranges: Array
    """(n,) [m]; inf where they meet no tape."""
    edges: NDArray[np.int64]
    """(n,) which edge they meet; -1 for none."""


class PlaceTracker:
    """A Kalman filter of one place and the errors of wheels: odometry predicts, scans correct."""

    def __init__(self, edges: Array, pose: Pose2, covariance: Array) -> None:
        """Begin at a pose with a covariance (3, 3) [m, m, rad]; edges (n, 4) [m] may be some."""
        self._matcher = ScanMatcher(index_edges(edges), REACH, RANGE_SD, GATE, SLOPE)
        self.pose = pose
        self.wheels = np.zeros(3)
        """Errors of odometry, as ``WHEELS_SD`` has them."""
        self._joint = joint_errors(covariance)
        self._joint_by_scans = joint_errors(UNKNOWN_SD**2 * np.eye(3))
        self.leap = 0.0
        """The farthest that a scan has moved the place, in standard deviations of odometry."""

    @property
    def covariance(self) -> Array:
        """Of the pose (3, 3) [m, m, rad]."""
        return self._joint[POSE, POSE].copy()

    @property
    def by_scans(self) -> Array:
        """The covariance, as if nothing had been known at the beginning."""
        return self._joint_by_scans[POSE, POSE].copy()

    def step(self, moved: Pose2, rays: Array) -> None:
        """Follow a step of odometry, and lay rays (n, 9) on the tape."""
        self._predict(moved)
        known = inverse(self.covariance)
        before = self.pose
        pose, information, _ = fit_rays(before.to_array(), known, rays, self._matcher)
        self.pose = Pose2(*pose.tolist())
        leap = before.offset_to(self.pose)
        self.leap = max(self.leap, math.sqrt(float(leap @ known @ leap)))
        self.wheels = self.wheels + self._joint[WHEELS, POSE] @ known @ leap
        gained = information - known
        _correct(self._joint, gained)
        _correct(self._joint_by_scans, gained)

    @property
    def width(self) -> float:
        """Largest standard deviation of the place [m]."""
        return widest(self.covariance)

    @property
    def spread(self) -> float:
        """Largest standard deviation of what is seen from the place [m]."""
        return self._widest_axis()[0]

    @property
    def others(self) -> tuple[Pose2, ...]:
        """Poses on both sides where it may well be as well; none if its place is known."""
        sd, axis = self._widest_axis()
        if sd < KNOWN_M:
            return ()
        x, y, turn = (min(BESIDE_SDS * sd, FARTHEST_BESIDE) * axis).tolist()
        pose = self.pose
        return (
            Pose2(pose.x + x, pose.y + y, pose.theta + turn),
            Pose2(pose.x - x, pose.y - y, pose.theta - turn),
        )

    def expected(self, rays: Array, pose: Pose2 | None = None, reach: float = REACH) -> Expected:
        """Return what rays (n, 9) should see of its edges within their reach [m].

        Args:
            rays: as taken.
            pose: from where; the tracker's own without one.
            reach: how far [m].
        """
        return expect(pose or self.pose, rays, self._matcher.edge_index, reach)

    def _predict(self, moved: Pose2) -> None:
        step = corrected_step(moved, self.wheels)
        self.wheels = LASTING * self.wheels
        predict(self._joint, self.pose, moved, step)
        predict(self._joint_by_scans, self.pose, moved, step)
        self.pose = self.pose @ step

    def _widest_axis(self) -> tuple[float, Array]:
        """Return how far what is seen may move [m], and by which pose (3,) it does by 1 m."""
        scale = np.array([1.0, 1.0, LEVER])
        variances, axes = np.linalg.eigh(self.covariance * np.outer(scale, scale))
        return math.sqrt(max(float(variances[2]), 0.0)), axes[:, 2] / scale


def _correct(joint: Array, gained: Array) -> None:
    """Correct a covariance (6, 6) by a scan with so much information of the pose (3, 3)."""
    pose = joint[POSE, POSE].copy()
    known = inverse(pose)
    gain = joint[:, POSE] @ known
    joint -= gain @ (pose - inverse(known + gained)) @ gain.T


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
