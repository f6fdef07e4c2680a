"""Do steps of the pose agree with odometry? If not: which of the two errs, and how?

Over a third of a second the pose moved by M and odometry by D; e = D^-1 M is what they differ by.
It is explained by seven errors that do not change: pictures stamped late by tau; wheels whose
radii are off (as a share k_f of the way, a turn k_t a metre) or whose track is (k_w of a turn);
and a camera that sees the floor from (o_x, o_y, psi) beside its place. They are estimated together
(recursive least squares with a prior): from few motions one looks like another, and the covariance
says so.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from robot.geometry import Array, Pose2, Twist2
from robot.localization.kernels.matrices import inverse

LAG, LONGEST = 0.33, 1.2
"""Time over which steps are compared, and most where pictures are few [s]."""
MEMORY = 20.0
"""Steps older than this hardly count for errors that stay [s]."""
RECENT = 3.0
"""The same for what is left unexplained [s]."""
CORRELATION = 5.0
"""Slip lasts for about a second: so many steps at the same speed are worth one."""
ERRORS = ("late", "forward", "turn_by_way", "turn", "ahead", "aside", "yaw")
WHEELS = slice(1, 4)
PRIOR_SD = np.array([0.015, 0.03, 0.5, 0.04, 0.002, 0.002, 0.008])
"""How far robots are off that nobody has calibrated [s, -, rad/m, -, m, m, rad]."""
PRIOR = np.diag(PRIOR_SD**-2)
TELLING, CHANGE_V, CHANGE_OMEGA = 2.0, 0.05, 0.4
"""A step over which the speed changes by more than this [m/s, rad/s] is worth so many: there slip
is the same before and after, and what is late shows."""
SETTLING = 1.5
"""For so long after a place was told or found, steps ahead and aside tell no tears [s]; to stand
there does not count, as the filter then takes no scans."""
MOST = 100.0
"""Squares of its spread that a step counts for, at most."""
MOST_WIGGLE = np.square([0.05, 0.05, 0.2])
SMALL = 1e-4
TAIL = 9.0


@dataclass(frozen=True, slots=True)
class OdometryErrors:
    """What steady errors the steps of the last seconds tell of."""

    values: Array = field(repr=False)
    """(7,) in the order of ``ERRORS``."""
    covariance: Array = field(repr=False)
    """(7, 7)"""
    rest: Array = field(repr=False)
    """(3,) root mean square of what is left of steps ahead, aside and in heading, by its spread."""
    steps: float
    """Steps that they are made of; those of long ago count less."""

    def value(self, name: str) -> float:
        """One of the errors."""
        return float(self.values[ERRORS.index(name)])

    def sd(self, name: str) -> float:
        """Its standard deviation."""
        place = ERRORS.index(name)
        return math.sqrt(float(self.covariance[place, place]))


@dataclass(frozen=True, slots=True)
class _Step:
    stamp: float
    pose: Pose2
    odometry: Pose2
    covariance: Array
    """(3, 3) of the pose along the robot's axes."""
    twist: Twist2


class OdometryCheck:
    """Compares each pose with that of a third of a second before."""

    def __init__(self) -> None:
        self._steps: deque[_Step] = deque()
        self._information = np.zeros((7, 7))
        self._pull = np.zeros(7)
        self._followed = 0.0
        """For how long the place has been followed while the robot drove [s]."""
        self._left = np.zeros(3)
        self._squares = np.zeros(3)
        self._recent = 0.0
        self._count = 0.0
        self._wiggle = np.zeros(3)
        self.errors = self._estimate()
        """The likeliest steady errors."""
        self.twist = Twist2(0.0, 0.0)
        """By odometry, at the last pose."""

    def jump(self) -> None:
        """Another place is followed from now on: no step leads there."""
        self._steps.clear()

    def begin_anew(self) -> None:
        """A place was told or found: at first its pose is set right, and steps are torn."""
        self.jump()
        self._followed = 0.0

    def observe(self, stamp: float, pose: Pose2, odometry: Pose2, covariance: Array) -> None:
        """Take a pose in the map with its covariance (3, 3), and odometry's, at a stamp."""
        c, s = math.cos(pose.theta), math.sin(pose.theta)
        robot_from_map = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        local = robot_from_map @ covariance @ robot_from_map.T
        twist = Twist2(0.0, 0.0)
        elapsed = 0.0
        if self._steps:
            last = self._steps[-1]
            elapsed = max(stamp - last.stamp, 1e-3)
            moved = last.odometry.inverse() @ odometry
            twist = Twist2(moved.x / elapsed, moved.theta / elapsed)
        self.twist = twist
        self._followed += elapsed if elapsed < LONGEST else 0.0
        current = _Step(stamp, pose, odometry, local, twist)
        before = self._before(stamp)
        if before is not None and elapsed < LONGEST:
            self._compare(before, current, elapsed)
        self._steps.append(current)
        while self._steps and stamp - self._steps[0].stamp > LONGEST:
            self._steps.popleft()

    def _before(self, stamp: float) -> _Step | None:
        before = None
        for step in self._steps:
            if stamp - step.stamp < LAG:
                break
            before = step
        return before

    def _compare(self, before: _Step, __step: _Step, elapsed: float) -> None:
        moved = before.odometry.inverse() @ __step.odometry
        went = before.pose.inverse() @ __step.pose
        offset = (moved.inverse() @ went).to_array()
        way = abs(moved.x) + 0.06 * abs(moved.theta)
        spread = np.array([0.0003 + 0.012 * way, 0.0002 + 0.003 * way, 0.001 + 0.18 * way])
        variance = np.square(spread) + np.diag(before.covariance) + np.diag(__step.covariance)
        columns = step_columns(
            moved.to_array(),
            np.array([before.twist.v, 0.0, before.twist.omega]),
            np.array([__step.twist.v, 0.0, __step.twist.omega]),
        )
        # Steps overlap; but what a change of speed tells, few of them tell.
        share = elapsed / max(__step.stamp - before.stamp, 1e-3)
        keep, recent = math.exp(-elapsed / MEMORY), math.exp(-elapsed / RECENT)
        left = offset - columns @ self.errors.values
        self._recent = recent * self._recent + share
        self._left = recent * self._left + share * left
        # What stays off is no slip, though it may not be learnt yet.
        unsteady = np.square(left - self._left / (self._recent + 1)) / variance
        if self._followed < SETTLING:
            unsteady[:2] = np.minimum(unsteady[:2], 1.0)
        # What slips now says less of what stays.
        wide = variance * np.maximum(self.errors.rest**2, 1.0)
        weights = share / (wide * (1 + unsteady / TAIL))
        self._information *= keep
        self._pull *= keep
        self._learn(columns, offset, weights / CORRELATION)
        if _has_changed(before.twist, __step.twist):
            # What its wheels are off by is not told by the one second in which it changes.
            beside_wheels = offset - columns[:, WHEELS] @ self.errors.values[WHEELS]
            columns[:, WHEELS] = 0.0
            self._learn(columns, beside_wheels, min(TELLING, 1 / share) * weights)
        self._squares = recent * self._squares + share * np.minimum(unsteady, MOST)
        self._wiggle = recent * self._wiggle + share * np.minimum(np.square(left), MOST_WIGGLE)
        self._count = keep * self._count + share
        self.errors = self._estimate()

    def _learn(self, columns: Array, offset: Array, weights: Array) -> None:
        self._information += (columns.T * weights) @ columns
        self._pull += (columns.T * weights) @ offset

    @property
    def wiggle(self) -> Array:
        """Covariance (3, 3) of what is left of steps, along the robot's axes."""
        left: Array = np.diag(self._wiggle / (self._recent + 1))
        return left

    def _estimate(self) -> OdometryErrors:
        information = self._information + PRIOR
        covariance = inverse(information)
        # As if a step before any had been as usual.
        rest = np.sqrt((self._squares + 1) / (self._recent + 1))
        return OdometryErrors(covariance @ self._pull, covariance, rest, self._count)


def _has_changed(first: Twist2, last: Twist2) -> bool:
    return abs(last.v - first.v) > CHANGE_V or abs(last.omega - first.omega) > CHANGE_OMEGA


@njit(cache=True, nogil=True)
def step_columns(moved: Array, first: Array, last: Array) -> Array:
    """How a step (3, 7) changes by a unit of each of ``ERRORS``, seen from its end.

    Args:
        moved: the step (3,) by odometry.
        first: velocity (3,) at its start.
        last: velocity (3,) at its end.
    """
    columns = np.zeros((3, 7))
    inverse = _inverse(moved)
    # Where it was tau earlier, at both ends.
    late = _compose(_compose(SMALL * first, moved), -SMALL * last)
    columns[:, 0] = _compose(inverse, late) / SMALL
    c, s = math.cos(moved[2]), math.sin(moved[2])
    columns[0, 1], columns[1, 1] = c * moved[0] + s * moved[1], c * moved[1] - s * moved[0]
    columns[1, 2], columns[2, 2] = 0.5 * moved[0] * moved[0], moved[0]
    columns[1, 3], columns[2, 3] = 0.5 * moved[0] * moved[2], moved[2]
    for axis in range(3):
        offset = np.zeros(3)
        offset[axis] = SMALL
        beside = _compose(_compose(_inverse(offset), moved), offset)
        columns[:, 4 + axis] = _compose(inverse, beside) / SMALL
    return columns


@njit(cache=True, nogil=True, inline="always")
def _compose(a: Array, b: Array) -> Array:
    c, s = math.cos(a[2]), math.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])


@njit(cache=True, nogil=True, inline="always")
def _inverse(a: Array) -> Array:
    c, s = math.cos(a[2]), math.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])
