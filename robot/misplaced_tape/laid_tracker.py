"""LaidTracker: follows a robot, and how far beside its drawing the tape lies that it sees."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from robot import ray_columns as column
from robot.fields.edge_index import EdgeIndex, index_edges
from robot.fields.edges import normals
from robot.geometry import Array, Pose2, heading_vectors
from robot.misplaced_tape.laid_tape import LaidTape
from robot.misplaced_tape.tracker import (
    LEAST_SD,
    SLOPE,
    Expected,
    StepErrors,
    expect,
    step_model,
)

REACH = 1.5
"""How far returns are compared [m]: those that are far away move the filter, too."""
RANGE_SD = 0.001
"""Standard deviation of a near range [m]."""
STEPS = StepErrors(ahead=0.0425, aside=0.015, turn=0.0425, turn_by_way=0.03)
"""What odometry errs by."""
MARGIN = 0.03
"""Tape so near to where a ray's sight begins may be missed [m]."""
STEEP = 0.25
"""Rays that meet an edge at a smaller sine of the angle tell too little."""
GATE, GATE_SDS, LEAST_GATE = 0.05, 4.0, 0.01
"""A return belongs to other tape if it lies farther from where it should be than any of these [m],
[standard deviations], but not if it is nearer than the last [m]."""
FEWEST = 3
"""Fewer returns of a scan tell nothing."""
LEAST_SHARE = 1e-9
"""Directions that a scan tells less about, as a share of the best, are left out."""


class _Looks(NamedTuple):
    """Rays that return tape which may be what was expected."""

    errors: Array
    """(n,) of their ranges [m]."""
    slopes: Array
    """(n, 3 + 2 k + 1) of the expected ranges, by pose and offsets."""
    variances: Array
    """(n,) of the ranges [m²]."""


class LaidTracker:
    """A Kalman filter of a place and of offsets: odometry predicts, scans correct.

    It is the map of SLAM (Thrun, Burgard, Fox: Probabilistic Robotics, chapter 10), with a prior:
    the drawing.
    """

    def __init__(self, tape: LaidTape, pose: Pose2, covariance: Array) -> None:
        """Begin at a pose with a covariance (3, 3) [m, m, rad]."""
        self.tape = tape
        self.pose = pose
        self.offsets = np.zeros(len(tape.prior))
        self._joint = np.zeros((3 + len(tape.prior),) * 2)
        self._joint[3:, 3:] = tape.prior
        self._joint[:3, :3] = covariance
        self.leap = 0.0
        """By how many standard deviations the last scan contradicts the step before it."""
        self.fits = self.misses = 0
        """How many returns of the last scan were as expected, and how many not."""
        self._lay()

    @property
    def covariance(self) -> Array:
        """Of the pose (3, 3) [m, m, rad]."""
        return self._joint[:3, :3].copy()

    @property
    def offsets_covariance(self) -> Array:
        """Of the offsets (2 k + 1, 2 k + 1)."""
        return self._joint[3:, 3:].copy()

    def restart(self, pose: Pose2, covariance: Array) -> None:
        """Go on elsewhere; what was learnt of the tape stays."""
        self.pose = pose
        self._joint[:3], self._joint[:, :3] = 0.0, 0.0
        self._joint[:3, :3] = covariance

    def step(self, moved: Pose2, rays: Array) -> None:
        """Follow a step of odometry, and compare rays (n, 9) with the tape."""
        motion, added = step_model(self.pose, moved, STEPS)
        self._joint[:3] = motion @ self._joint[:3]
        self._joint[:, :3] = self._joint[:, :3] @ motion.T
        self._joint[:3, :3] += added + LEAST_SD**2 * np.eye(3)
        self.pose = self.pose @ moved
        self.leap = 0.0
        errors, slopes, variances = self._looks(rays)
        spread = slopes @ self._joint
        expected = (spread * slopes).sum(axis=1) + variances
        gate = np.minimum(GATE, np.maximum(LEAST_GATE, GATE_SDS * np.sqrt(expected)))
        fits = np.abs(errors) < gate
        self.fits, self.misses = int(fits.sum()), int((~fits).sum())
        if self.fits < FEWEST:
            return
        errors, slopes, spread = errors[fits], slopes[fits], spread[fits]
        innovation = spread @ slopes.T + np.diag(variances[fits])
        self.leap = _leap(errors, slopes[:, :3] / variances[fits, None], innovation)
        gain = np.linalg.solve(innovation, spread).T
        change = gain @ errors
        joint = self._joint - gain @ spread
        self._joint = (joint + joint.T) / 2
        dx, dy, turn = change[:3].tolist()
        self.pose = Pose2(self.pose.x + dx, self.pose.y + dy, self.pose.theta + turn)
        self.offsets = self.offsets + change[3:]
        self._lay()

    def expected(self, pose: Pose2, rays: Array, *, drawn: bool = False) -> Array:
        """Return what rays (n, 9) should see from a pose (n,) [m]; as laid, or as drawn."""
        return self._expected(pose, rays, self.tape.drawn if drawn else self._index).ranges

    def _expected(self, pose: Pose2, rays: Array, index: EdgeIndex) -> Expected:
        # Nothing before a ray's sight hides what lies in it.
        near = np.nan_to_num(rays[:, column.NEAR])
        seen = rays.copy()
        seen[:, [column.X, column.Y]] += near[:, None] * heading_vectors(rays[:, column.DIRECTION])
        result = expect(pose, seen, index, REACH)
        return Expected(result.ranges + near, result.edges)

    def _lay(self) -> None:
        self._edges = self.tape.laid(self.offsets)
        self._index, self._across = index_edges(self._edges), normals(self._edges)

    def _looks(self, rays: Array) -> _Looks:
        ranges, edges = self._expected(self.pose, rays, self._index)
        towards = heading_vectors(self.pose.theta + rays[:, column.DIRECTION])
        steep = -(self._across[edges] * towards).sum(axis=1) > STEEP
        seen = np.isfinite(rays[:, column.RANGE]) & (rays[:, column.RANGE] < REACH)
        used = seen & steep & np.isfinite(ranges) & (ranges > rays[:, column.NEAR] + MARGIN)
        rays, ranges, edges, towards = rays[used], ranges[used], edges[used], towards[used]
        starts = self.pose.apply(rays[:, [column.X, column.Y]])
        points = starts + ranges[:, None] * towards
        across = self._across[edges]
        # How a range grows when the edge moves along x, and along y.
        by_edge = across / (across * towards).sum(axis=1)[:, None]
        x, y = (points - (self.pose.x, self.pose.y)).T
        by_turn = by_edge[:, 0] * y - by_edge[:, 1] * x
        first, last = self._edges[edges, :2], self._edges[edges, 2:]
        share = ((points - first) * (last - first)).sum(axis=1) / ((last - first) ** 2).sum(axis=1)
        tape, before, after = self.tape, 1 - share[:, None], share[:, None]
        weights = before * tape.start_weights[edges] + after * tape.end_weights[edges]
        drawn = before * tape.starts[edges] + after * tape.ends[edges]
        by_scale = (by_edge * drawn).sum(axis=1)
        slopes = np.column_stack(
            [-by_edge, by_turn, by_edge[:, :1] * weights, by_edge[:, 1:] * weights, by_scale]
        )
        deviations = RANGE_SD * (1 + SLOPE * ranges**2)
        return _Looks(rays[:, column.RANGE] - ranges, slopes, deviations**2)


def _leap(errors: Array, by_pose: Array, innovation: Array) -> float:
    """Return by how many standard deviations errors (n,) ask for another pose.

    Args:
        errors: of ranges [m].
        by_pose: (n, 3) slopes by pose, divided by the ranges' variances.
        innovation: covariance (n, n) that errors should have.
    """
    values, axes = np.linalg.eigh(by_pose.T @ innovation @ by_pose)
    asked = axes.T @ (by_pose.T @ errors)
    told = values > LEAST_SHARE * values[-1]
    return math.sqrt(float((asked[told] ** 2 / values[told]).sum()))
