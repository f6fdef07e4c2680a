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

from robot.covariance import inverse, widest
from robot.geometry import Array, Pose2, Twist2, turned_covariance
from robot.localization.monitoring.slip_check import LEAST, LEVER
from robot.localization.monitoring.steady_errors import SteadyErrors
from robot.localization.monitoring.step_sums import (
    StepSums,
    add_step,
    estimate_errors,
    forget_lateness,
)

LAG, LONGEST = 0.33, 1.2
"""Time over which steps are compared, and the longest such time when pictures are rare [s]. Half of
LAG: the cause of an error is named in 57.3 % of pictures instead of 60.7; twice: 44.8."""
ERRORS = ("late", "forward", "turn_by_way", "turn", "ahead", "aside", "yaw")
USUAL = SteadyErrors()
LATE_STEP = 0.04
"""Standard deviation of how much later pictures may come all at once [s]. If they come 90 ms later
for a while (*stub*, *square* and *tee*, seeds 710 and 711), 0.8 % are certain and wrong, for 0.1 s;
with three quarters of it 2.4 %, for 0.4 s; without it 10.5 %, for 4.1 s."""
LATE_JOLT, LATE_SDS, SLIDING = 0.003, 2.0, 0.1
"""Lateness explains a step if it moves the robot by more than this [m], and by more standard
deviations than this; steps by wheels err by this share (1 sd). On *stub*, *town* and *tee*
(``brickpose evaluate integrity``, late-for-a-while and slippery, seeds 12500 and 12501) no picture
misleads, and 48 and 68 % are certain; half or twice: 0.03 % of the late ones mislead with twice
LATE_JOLT and half of SLIDING, and no share of certain ones changes by more than 2."""
BLURRED = 2.0
"""A pose that tells less than this of lateness, as a ratio of standard deviations, is not the last
that was known well. Half, on the same drives: 41 % of the late ones certain, not 48; twice: nothing
changes."""
AGREEING = 1.5
"""Wheels that slip by more spreads explain what lateness would. Half, on the same drives: 0.03 % of
the late ones mislead; twice: nothing changes."""
STANDS, STANDS_WAY, STANDS_S = 0.3, 0.012, 0.3
"""A robot is stuck if it moves by less than this share of its wheels' way, if that is longer than
this [m], for longer than this [s]. Of 6 that are stuck (*square*, *town*, *stub*, seeds 15200 and
15201) 5 hear so. Half of each, and twice of the way: as many; twice of the others: 3."""
SETTLING = 1.5
"""Until the robot has driven for this long after a place was given or found, steps ahead and aside
do not contradict odometry [s]. Time at rest does not count, as the filter then takes no scans.
Half: nothing changes beyond chance; twice: 41.3 % certain."""


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

    @property
    def motion(self) -> Array:
        """(3,) how the pose changes in a second [m, m, rad]."""
        return np.array([self.twist.v, 0.0, self.twist.omega])

    @property
    def tells(self) -> float:
        """Information of the pose on when its picture was taken [1/s²]."""
        return float(self.motion @ inverse(self.covariance + LEAST * np.eye(3)) @ self.motion)


class OdometryCheck:
    """Compares each pose with the pose a third of a second earlier."""

    def __init__(self, errors: SteadyErrors = USUAL) -> None:
        """Begin with how large the errors may be."""
        self._steps: deque[_Step] = deque()
        empty = (np.zeros(size) for size in (7, (3, 7, 7), (3, 7), 3, 3, 3, 2))
        self._sums = StepSums(np.diag(errors.odometry**-2), *empty)
        self._known: _Step | None = None
        """The last pose that was known well: steps from it show what came while nothing was seen.
        """
        self._last: tuple[float, Pose2] | None = None
        """Stamp and odometry of the last pose; where odometry is, no jump of the pose changes."""
        self._followed = 0.0
        """How long the place has been followed while the robot drove [s]."""
        self.standing = 0.0
        """How long the robot has been standing while its wheels turn [s]."""
        self.stuck_at = -math.inf
        """Stamp at which the robot was last stuck while its wheels turned [s]."""
        self.errors = self._estimated(estimate_errors(self._sums))
        """The likeliest steady errors."""
        self.twist = Twist2(0.0, 0.0)
        """Twist by odometry at the last pose."""

    @property
    def settled(self) -> bool:
        """Whether the place has been followed for long enough for steps to be believed."""
        return self._followed >= SETTLING

    @property
    def agrees(self) -> bool:
        """Whether steps show that wheels hardly slip; those that slip may do so more, or less."""
        return self.errors.steps > 0 and float(self.errors.rest.max()) <= AGREEING

    def jump(self) -> None:
        """Forget earlier poses, because no step leads from them to the next one."""
        self._steps.clear()

    def restart(self) -> None:
        """Restart at a given or found place: its pose is corrected at first, and steps jump."""
        self.jump()
        self._last, self._known, self._followed = None, None, 0.0

    def doubt_lateness(self) -> None:
        """Let pictures be as late as ``LATE_STEP`` says, whatever earlier steps told.

        Pictures that come later all at once look like a robot that was carried.
        """
        if self.errors.sd("late") < LATE_STEP:
            forget_lateness(self._sums, self.errors.value("late"), LATE_STEP)
            self.errors = self._estimated(estimate_errors(self._sums))

    def observe(self, stamp: float, pose: Pose2, odometry: Pose2, covariance: Array) -> None:
        """Add a pose in the map with its covariance (3, 3), and odometry's pose, at a stamp."""
        last, self._last = self._last, (stamp, odometry)
        elapsed = math.inf if last is None else max(stamp - last[0], 1e-3)
        if last is None or elapsed >= LONGEST:
            return  # nobody knows how fast it drives
        moved = last[1].inverse() @ odometry
        self.twist = Twist2(moved.x / elapsed, moved.theta / elapsed)
        self._followed += elapsed
        local = turned_covariance(covariance, -pose.theta)
        current = _Step(stamp, pose, odometry, local, self.twist)
        before = self._before(stamp)
        if before is not None:
            self.standing = self.standing + elapsed if _stands(before, current) else 0.0
            self.stuck_at = stamp if self.standing > STANDS_S else self.stuck_at
            if self.standing == 0:  # other steps tell nothing of the robot's errors
                self._compare(before, current, elapsed)
        known = self._known
        if known is not None and self._may_be_late(known, current):
            self.doubt_lateness()
        if (
            known is None
            or stamp - known.stamp > LONGEST
            or BLURRED**2 * current.tells > known.tells
        ):
            self._known = current
        self._steps.append(current)
        while self._steps and stamp - self._steps[0].stamp > LONGEST:
            self._steps.popleft()

    def _may_be_late(self, before: _Step, after: _Step) -> bool:
        """Return whether pictures that come later or earlier all at once would explain a step."""
        if not self.agrees:
            return False
        moved = before.odometry.inverse() @ after.odometry
        offset = (moved.inverse() @ before.pose.inverse() @ after.pose).to_array()
        slid = np.diag((SLIDING * moved.to_array()) ** 2 + LEAST)
        weighed = after.motion @ inverse(before.covariance + after.covariance + slid)
        information, pull = float(weighed @ after.motion), float(weighed @ offset)
        speed = math.hypot(after.twist.v, LEVER * after.twist.omega)
        surely = abs(pull) > LATE_SDS * math.sqrt(information)
        return surely and abs(pull) * speed > LATE_JOLT * information

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


def _stands(before: _Step, after: _Step) -> bool:
    """Whether scans prove that the robot stands while its wheels turn."""
    by_wheels = before.odometry.distance_to(after.odometry)
    farthest = before.pose.distance_to(after.pose) + widest(before.covariance + after.covariance)
    return by_wheels > STANDS_WAY and farthest < STANDS * by_wheels
