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

from robot.geometry import Array, Pose2, Twist2
from robot.localization.monitoring.step_sums import StepSums, learned, likeliest

LAG, LONGEST = 0.33, 1.2
"""Time over which steps are compared, and most where pictures are few [s]."""
ERRORS = ("late", "forward", "turn_by_way", "turn", "ahead", "aside", "yaw")
SETTLING = 1.5
"""For so long after a place was told or found, steps ahead and aside tell no tears [s]; to stand
there does not count, as the filter then takes no scans."""


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
        self._sums = StepSums(*(np.zeros(size) for size in ((7, 7), 7, 3, 3, 3, 2)))
        self._followed = 0.0
        """For how long the place has been followed while the robot drove [s]."""
        self.errors = self._estimated(likeliest(self._sums))
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

    def _compare(self, before: _Step, after: _Step, elapsed: float) -> None:
        errors = self.errors
        result = learned(
            self._sums,
            errors.values,
            errors.rest,
            (before.odometry.inverse() @ after.odometry).to_array(),
            (before.pose.inverse() @ after.pose).to_array(),
            (before.twist.v, before.twist.omega),
            (after.twist.v, after.twist.omega),
            before.covariance,
            after.covariance,
            elapsed,
            after.stamp - before.stamp,
            self._followed >= SETTLING,
        )
        self.errors = self._estimated(result)

    def _estimated(self, result: tuple[Array, Array, Array]) -> OdometryErrors:
        values, covariance, rest = result
        return OdometryErrors(values, covariance, rest, float(self._sums.counts[0]))

    @property
    def wiggle(self) -> Array:
        """Covariance (3, 3) of what is left of steps, along the robot's axes."""
        left: Array = np.diag(self._sums.wiggle / (self._sums.counts[1] + 1))
        return left
