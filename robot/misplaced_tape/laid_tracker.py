"""LaidTracker: follows a robot, and how far beside its drawing the tape lies that it sees."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot import ray_columns as column
from robot.fields.edge_index import EdgeIndex, index_edges
from robot.fields.edges import normals
from robot.geometry import Array, Pose2, heading_vectors
from robot.localization.monitoring.mounting_check import CameraPosition
from robot.misplaced_tape.laid_tape import LaidTape
from robot.misplaced_tape.odometry_errors import (
    LASTING,
    POSE,
    WHEELS,
    corrected_step,
    joint_errors,
    predict,
)
from robot.misplaced_tape.tracker import SLOPE, Expected, expect

RAY_WORTH = 0.3
"""Weight of one ray: errors of neighbouring rays, and of scans one after the other, are alike."""
REACH = 1.5
"""How far returns are compared [m]: those that are far away move the filter, too."""
RANGE_SD = 0.001
"""Standard deviation of a near range [m]."""
CAMERA_SD = (math.radians(0.3), math.radians(0.3), 0.003)
"""What a camera errs by that was mounted with care: pitch and roll [rad], and its height, or focal
length, as a share; standard deviations."""
CAMERA, OFFSETS = slice(6, 9), slice(9, None)
"""Where the state has the errors of the camera, and offsets; pose and wheels come before."""
MARGIN = 0.03
"""Tape so near to where a ray's sight begins may be missed [m]."""
STEEP, LEAST_STEEP = 0.25, 0.05
"""Rays that meet an edge at a smaller sine of the angle tell too little; by no smaller one a range
is divided."""
GATE, GATE_SDS, LEAST_GATE = 0.05, 4.0, 0.01
"""A return belongs to other tape if it lies farther from where it should be than any of these [m],
[standard deviations], but not if it is nearer than the last [m]."""
DUE, CLEAR = 0.5, 0.5
"""Tape nearer than this [m] must be seen, by rays that return it with a larger probability."""
LARGEST_OFFSET = 0.035
"""Tape that lies farther aside was not laid so by hand [m]."""
UNLIKELY = 3.5
"""Nor tape of which so much lies far aside [standard deviations]."""
LAID_ANEW = 2e-5
"""Tape is laid anew once an offset has changed by more [m], or the scale by such a share."""
FEWEST = 3
"""Fewer returns of a scan tell nothing."""
LARGEST_LEAP = 10.0
"""No leap surprises by more [standard deviations]."""
LEAST_SHARE = 1e-9
"""Directions that a scan tells less about, as a share of the best, are left out."""


class _Looks(NamedTuple):
    """Rays that return tape which may be what was expected."""

    errors: Array
    """(n,) of their ranges [m]."""
    slopes: Array
    """(n, 9 + 2 k + 1) of the expected ranges, by all that the state has."""
    variances: Array
    """(n,) of the ranges [m²]."""
    unseen: int
    """How many other rays return nothing, where tape is expected."""


class LaidTracker:
    """A Kalman filter of place, wheels, camera and offsets: odometry predicts, scans correct.

    It is the map of SLAM (Thrun, Burgard, Fox: Probabilistic Robotics, chapter 10), with a prior:
    the drawing.
    """

    def __init__(
        self, tape: LaidTape, mounting: CameraPosition, pose: Pose2, covariance: Array
    ) -> None:
        """Begin at a pose with a covariance (3, 3) [m, m, rad]; a camera, or a laser, looks."""
        self.tape, self._mounting = tape, mounting
        self.pose = pose
        self.wheels = np.zeros(3)
        """Errors of odometry, as ``WHEELS_SD`` has them."""
        self.camera = np.zeros(3)
        """Errors of the camera, as ``CAMERA_SD`` has them."""
        self.offsets = np.zeros(len(tape.prior))
        self._joint = joint_errors(covariance, OFFSETS.start + len(tape.prior))
        if math.isfinite(mounting.height):
            self._joint[CAMERA, CAMERA] = np.diag(np.square(CAMERA_SD))
        self._joint[OFFSETS, OFFSETS] = tape.prior
        self.leap = self.surprise = 0.0
        """By how many standard deviations the last scan contradicts the step before it; and minus
        twice the log-likelihood of that, but for what is the same with any tape."""
        self.fits = self.misses = 0
        """How many returns of the last scan were as expected, and how many not."""
        self._lay()

    @property
    def covariance(self) -> Array:
        """Of the pose (3, 3) [m, m, rad]."""
        return self._joint[POSE, POSE].copy()

    @property
    def is_plausible(self) -> bool:
        """Whether the tape may lie so, if it was laid by hand."""
        aside = np.hypot(*self.tape.shifts(self.offsets).T)
        near = len(aside) == 0 or float(aside.max()) < LARGEST_OFFSET
        return near and self.tape.unlikelihood(self.offsets) < UNLIKELY

    @property
    def offsets_covariance(self) -> Array:
        """Of the offsets (2 k + 1, 2 k + 1)."""
        return self._joint[OFFSETS, OFFSETS].copy()

    def restart(self, pose: Pose2, covariance: Array) -> None:
        """Go on elsewhere; what was learnt of tape and wheels stays."""
        self.pose = pose
        self._joint[POSE], self._joint[:, POSE] = 0.0, 0.0
        self._joint[POSE, POSE] = covariance

    def step(self, moved: Pose2, rays: Array) -> None:
        """Follow a step of odometry, and compare rays (n, 9) with the tape."""
        self._predict(moved)
        self.leap = self.surprise = 0.0
        errors, slopes, variances, unseen = self._looks(rays)
        spread = slopes @ self._joint
        expected = (spread * slopes).sum(axis=1) + variances
        gate = np.minimum(GATE, np.maximum(LEAST_GATE, GATE_SDS * np.sqrt(expected)))
        fits = np.abs(errors) < gate
        self.fits, self.misses = int(fits.sum()), unseen + int((~fits).sum())
        if self.fits < FEWEST:
            return
        errors, slopes, spread = errors[fits], slopes[fits], spread[fits]
        innovation = spread @ slopes.T + np.diag(variances[fits])
        self.leap, self.surprise = _leap(errors, slopes[:, POSE], variances[fits], innovation)
        rays_alike = spread @ slopes.T + np.diag(variances[fits] / RAY_WORTH)
        gain = np.linalg.solve(rays_alike, spread).T
        change = gain @ errors
        joint = self._joint - gain @ spread
        self._joint = (joint + joint.T) / 2
        dx, dy, turn = change[POSE].tolist()
        self.pose = Pose2(self.pose.x + dx, self.pose.y + dy, self.pose.theta + turn)
        self.wheels = self.wheels + change[WHEELS]
        self.camera = self.camera + change[CAMERA]
        self.offsets = self.offsets + change[OFFSETS]
        if np.abs(self.offsets - self._laid_by).max(initial=0.0) > LAID_ANEW:
            self._lay()

    def _predict(self, moved: Pose2) -> None:
        step = corrected_step(moved, self.wheels)
        self.wheels = LASTING * self.wheels
        predict(self._joint, self.pose, moved, step)
        self.pose = self.pose @ step

    def expected(self, rays: Array) -> Array:
        """Return what rays (n, 9) should see (n,) [m]: the tape as laid, by the camera as it is."""
        ranges, edges = self._expected(self.pose, rays, self._index)
        seen = np.isfinite(ranges)
        rays, edges = rays[seen], edges[seen]
        towards = heading_vectors(self.pose.theta + rays[:, column.DIRECTION])
        points = self._points(rays, ranges[seen], towards)
        by_edge = self._by_edge(edges, towards)
        ranges[seen] += self._by_camera(by_edge, points) @ self.camera
        return ranges

    def drawn(self, pose: Pose2, rays: Array) -> Array:
        """Return what rays (n, 9) should see from a pose (n,) [m] if all were as drawn."""
        return self._expected(pose, rays, self.tape.drawn).ranges

    def _expected(self, pose: Pose2, rays: Array, index: EdgeIndex) -> Expected:
        # Nothing before a ray's sight hides what lies in it.
        near = np.nan_to_num(rays[:, column.NEAR])
        seen = rays.copy()
        seen[:, [column.X, column.Y]] += near[:, None] * heading_vectors(rays[:, column.DIRECTION])
        result = expect(pose, seen, index, REACH)
        return Expected(result.ranges + near, result.edges)

    def _lay(self) -> None:
        self._laid_by = self.offsets
        self._edges = self.tape.laid(self.offsets)
        self._index, self._across = index_edges(self._edges), normals(self._edges)

    def _looks(self, rays: Array) -> _Looks:
        ranges, edges = self._expected(self.pose, rays, self._index)
        towards = heading_vectors(self.pose.theta + rays[:, column.DIRECTION])
        steep = -(self._across[edges] * towards).sum(axis=1) > STEEP
        seen = np.isfinite(rays[:, column.RANGE])
        due = steep & np.isfinite(ranges) & (ranges > rays[:, column.NEAR] + MARGIN)
        clear = ~np.isfinite(rays[:, column.HIDDEN_FROM]) & (rays[:, column.CLEAR] > CLEAR)
        unseen = ~seen & clear & (ranges < np.minimum(rays[:, column.FAR] - MARGIN, DUE))
        used = due & seen & (rays[:, column.RANGE] < REACH)
        missing = int((due & unseen).sum())
        rays, ranges, edges, towards = rays[used], ranges[used], edges[used], towards[used]
        points, by_edge = self._points(rays, ranges, towards), self._by_edge(edges, towards)
        x, y = (points - (self.pose.x, self.pose.y)).T
        by_turn = by_edge[:, 0] * y - by_edge[:, 1] * x
        first, last = self._edges[edges, :2], self._edges[edges, 2:]
        share = ((points - first) * (last - first)).sum(axis=1) / ((last - first) ** 2).sum(axis=1)
        tape, before, after = self.tape, 1 - share[:, None], share[:, None]
        weights = before * tape.start_weights[edges] + after * tape.end_weights[edges]
        drawn = before * tape.starts[edges] + after * tape.ends[edges]
        by_scale = (by_edge * drawn).sum(axis=1)
        by_offsets = [by_edge[:, :1] * weights, by_edge[:, 1:] * weights, by_scale]
        by_camera = self._by_camera(by_edge, points)
        ranges = ranges + by_camera @ self.camera
        none = np.zeros((len(ranges), 3))
        slopes = np.column_stack([-by_edge, by_turn, none, by_camera, *by_offsets])
        deviations = RANGE_SD * (1 + SLOPE * ranges**2)
        return _Looks(rays[:, column.RANGE] - ranges, slopes, deviations**2, missing)

    def _points(self, rays: Array, ranges: Array, towards: Array) -> Array:
        """Return the points (n, 2) [m] that rays (n, 9) see at these ranges."""
        return self.pose.apply(rays[:, [column.X, column.Y]]) + ranges[:, None] * towards

    def _by_edge(self, edges: NDArray[np.int64], towards: Array) -> Array:
        """Return how ranges (n, 2) grow when the edges move along x, and along y."""
        across = self._across[edges]
        steep: Array = (across * towards).sum(axis=1)
        return across / np.minimum(steep, -LEAST_STEEP)[:, None]

    def _by_camera(self, by_edge: Array, points: Array) -> Array:
        """Return how ranges (n, 3) [m] grow with the camera's errors: points seem to move."""
        if not math.isfinite(self._mounting.height):
            return np.zeros((len(points), 3))
        local = self.pose.inverse().apply(points)
        away = local - (self._mounting.x, 0.0)
        moves = np.concatenate([self._mounting.shifts(local), away[:, :, None]], axis=2)
        axes = heading_vectors(self.pose.theta + np.array([0.0, math.pi / 2]))
        result: Array = np.einsum("ij,ijk->ik", by_edge @ axes.T, moves)
        return result


def _leap(errors: Array, slopes: Array, variances: Array, innovation: Array) -> tuple[float, float]:
    """Return by how many standard deviations errors ask for another pose, and the surprise.

    Args:
        errors: of ranges (n,) [m].
        slopes: of ranges by the pose (n, 3).
        variances: of each range alone (n,) [m²].
        innovation: covariance (n, n) that errors should have.
    """
    by_pose = slopes / variances[:, None]
    expected, alone = by_pose.T @ innovation @ by_pose, slopes.T @ by_pose
    values, axes = np.linalg.eigh(expected)
    asked = axes.T @ (by_pose.T @ errors)
    counts = values > LEAST_SHARE * values[-1]
    squared = float((asked[counts] ** 2 / values[counts]).sum())
    least = LEAST_SHARE * np.trace(alone) * np.eye(3)
    wider = np.linalg.slogdet(expected + least)[1] - np.linalg.slogdet(alone + least)[1]
    leap = math.sqrt(squared)
    return leap, min(leap, LARGEST_LEAP) ** 2 + float(wider)
