"""Compares steps of the pose with odometry, and estimates which of the two errs, and how.

Over a third of a second, the pose moves by M and odometry by D; their difference is e = D^-1 M.
Seven constant errors explain it: pictures stamped late by tau; wheels whose radii are off (a share
k_f of a distance, a turn k_t a metre) or whose track is off (a share k_w of a turn); and a camera
that is shifted by (o_x, o_y, psi) from its place. They are estimated together, by recursive least
squares with a prior. After few motions one error looks like another, and the covariance says so.

What half and twice of a constant change is said as ``python -m benchmarks.constants --few`` found
it: of pictures 40.7 % are certain and 0.7 % misleading.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from robot.geometry import Array, Pose2, Twist2, turned_covariance
from robot.localization.monitoring.steady_errors import SteadyErrors
from robot.localization.monitoring.step_sums import (
    CHANGE_OMEGA,
    CHANGE_V,
    StepSums,
    add_step,
    estimate_errors,
    jump_lateness,
)

LAG, LONGEST = 0.33, 1.2
"""Time over which steps are compared, and the longest such time when pictures are rare [s]. Half of
LAG: the cause of an error is named in 57.3 % of pictures instead of 60.7; twice: 44.8."""
ERRORS = ("late", "forward", "turn_by_way", "turn", "ahead", "aside", "yaw")
USUAL = SteadyErrors()
SETTLING = 1.5
"""Until the robot has driven for this long after a place was given or found, steps ahead and aside
do not contradict odometry [s]. Time at rest does not count, as the filter then takes no scans.
Half: nothing changes beyond chance; twice: 41.3 % certain."""
JUMP, JUMP_BY_TIME, JUMP_SURE = 0.02, 0.25, 5.0
"""Pictures come later all at once, or earlier, if a pose seems to be reached later by JUMP [s] and
by this share of the time since the last picture, and by so many standard deviations. Of a robot
whose pictures come on time, 12 ms is the most that a picture seems late by chance."""
LATEST_JUMP, JUMP_SD, ALONG = 0.2, 0.3, 0.8
"""What seems to come later by more [s] was moved. A jump is known up to this share of itself, and
must explain this share of the squared difference from odometry."""


@dataclass(frozen=True, slots=True, eq=False)
class OdometryErrors:
    """Steady errors, estimated from the steps of the last seconds."""

    values: Array = field(repr=False)
    """(7,) in the order of ``ERRORS``."""
    covariance: Array = field(repr=False)
    """(7, 7)"""
    rest: Array = field(repr=False)
    """(3,) root mean square of the unexplained rest ahead, aside and in heading, in its spreads."""
    steps: float
    """Number of steps behind the estimate; old ones count less."""

    def value(self, name: str) -> float:
        """Return the value of one of ``ERRORS``."""
        return float(self.values[ERRORS.index(name)])

    def sd(self, name: str) -> float:
        """Return the standard deviation of one of ``ERRORS``."""
        place = ERRORS.index(name)
        return math.sqrt(float(self.covariance[place, place]))

    @property
    def of_wheels(self) -> tuple[float, ...]:
        """What exceeds one standard deviation of the wheels' errors.

        Forward [-], turn by distance [rad/m], and turn [-].
        """
        values, variances = self.values[1:4].tolist(), self.covariance.diagonal()[1:4].tolist()
        return tuple(
            math.copysign(max(abs(value) - math.sqrt(variance), 0.0), value)
            for value, variance in zip(values, variances, strict=True)
        )


@dataclass(frozen=True, slots=True, eq=False)
class _Step:
    stamp: float
    pose: Pose2
    odometry: Pose2
    covariance: Array
    """(3, 3) of the pose along the robot's axes."""
    twist: Twist2


class OdometryCheck:
    """Compares each pose with the pose a third of a second earlier."""

    def __init__(self, errors: SteadyErrors = USUAL) -> None:
        """Begin with how large the errors may be."""
        self._steps: deque[_Step] = deque()
        empty = (np.zeros(size) for size in ((7, 7), 7, 3, 3, 3, 3, 2))
        self._sums = StepSums(np.diag(errors.odometry**-2), *empty)
        self._last: tuple[float, Pose2] | None = None
        """Stamp and odometry of the last pose; where odometry is, no jump of the pose changes."""
        self._followed = 0.0
        """How long the place has been followed while the robot drove [s]."""
        self._slipping = 0.0
        """How much later the last pose seemed to be reached than the one before [s]."""
        self.errors = self._estimated(estimate_errors(self._sums))
        """The likeliest steady errors."""
        self.twist = Twist2(0.0, 0.0)
        """Twist by odometry at the last pose."""

    @property
    def settled(self) -> bool:
        """Whether the place has been followed for long enough for steps to be believed."""
        return self._followed >= SETTLING

    def jump(self) -> None:
        """Forget earlier poses, because no step leads from them to the next one."""
        self._steps.clear()

    def restart(self) -> None:
        """Restart at a given or found place: its pose is corrected at first, and steps jump."""
        self.jump()
        self._last, self._followed = None, 0.0

    def observe(self, stamp: float, pose: Pose2, odometry: Pose2, covariance: Array) -> None:
        """Add a pose in the map with its covariance (3, 3), and odometry's pose, at a stamp."""
        local = turned_covariance(covariance, -pose.theta)
        elapsed = 0.0
        if self._last is not None:
            last, before_odometry = self._last
            elapsed = max(stamp - last, 1e-3)
            moved = before_odometry.inverse() @ odometry
            self.twist = Twist2(moved.x / elapsed, moved.theta / elapsed)
        self._last = stamp, odometry
        self._followed += elapsed if elapsed < LONGEST else 0.0
        current = _Step(stamp, pose, odometry, local, self.twist)
        before = self._before(stamp)
        if before is not None and elapsed < LONGEST:
            self._compare(before, current, elapsed)
        if self._steps:
            self._notice_jump(self._steps[-1], current)
        self._steps.append(current)
        while self._steps and stamp - self._steps[0].stamp > LONGEST:
            self._steps.popleft()

    def _notice_jump(self, before: _Step, after: _Step) -> None:
        """Take in that pictures come later than before, all at once, or earlier.

        The pose then differs from odometry along the twist, in place and heading alike. Slip does,
        too, but for longer than one picture, and by less than the whole way.
        """
        moved = before.odometry.inverse() @ after.odometry
        offset = (moved.inverse() @ before.pose.inverse() @ after.pose).to_array()
        variances = (before.covariance + after.covariance).diagonal()
        column = np.array([-after.twist.v, 0.0, -after.twist.omega])
        information = float(column @ (column / variances))
        later = float(column @ (offset / variances)) / max(information, 1e-9)
        change, self._slipping = later - self._slipping, later
        least = JUMP + JUMP_BY_TIME * (after.stamp - before.stamp)
        explained = later**2 * information > ALONG * float(offset @ (offset / variances))
        sure = change**2 * information > JUMP_SURE**2
        jumped = explained and sure and least < abs(change) and abs(later) < LATEST_JUMP
        # While the speed changes, constant lateness shows in the same way.
        recent = (step.twist for step in self._steps if after.stamp - step.stamp < LAG)
        if self.settled and jumped and all(_alike(twist, after.twist) for twist in recent):
            jump_lateness(self._sums, change, JUMP_SD)
            self.errors, self._slipping = self._estimated(estimate_errors(self._sums)), 0.0
            self._steps.clear()

    def _before(self, stamp: float) -> _Step | None:
        before = None
        for step in self._steps:
            if stamp - step.stamp < LAG:
                break
            before = step
        return before

    def _compare(self, before: _Step, after: _Step, elapsed: float) -> None:
        errors = self.errors
        result = add_step(
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
            self.settled,
        )
        self.errors = self._estimated(result)

    def _estimated(self, result: tuple[Array, Array, Array]) -> OdometryErrors:
        values, covariance, rest = result
        return OdometryErrors(values, covariance, rest, float(self._sums.counts[0]))

    @property
    def step_covariance(self) -> Array:
        """Covariance (3, 3) of the unexplained rest of steps, along the robot's axes."""
        left: Array = np.diag(self._sums.wiggle / (self._sums.counts[1] + 1))
        return left


def _alike(twist: Twist2, other: Twist2) -> bool:
    return abs(twist.v - other.v) < CHANGE_V and abs(twist.omega - other.omega) < CHANGE_OMEGA
