"""Compares how the floor moves with what the wheels say, for each way to plug motors in wrongly.

The tape that is seen now is laid on that seen a moment before, by the motion that the wheels told
meanwhile, and by those that they would have told with other plugs. Motors that are plugged in
rightly lay it where it was, whatever they do; slip, lateness and a wrong map change little of that.
A mirrored picture moves as that of a robot whose motors are in each other's place.
"""

from __future__ import annotations

import math
from enum import Enum

import numpy as np

from robot.geometry import Array, Pose2, Twist2
from robot.scan import Scan
from robot.scan_checks.overlay import FEWEST, misfit, near_points

STRIDE = 0.02
"""Tape is compared after each such way of either wheel [m]."""
LONGEST = 1.0
"""After a longer time without a scan, or one that runs back, comparing begins anew [s]."""
LIES, MISSES = 0.004, 0.010
"""Tape is laid rightly if it is off by less than this [m], and wrongly if by more."""
SURE, MOST = 4, 8
"""A motion has to be the only right one so many times before it is believed; more than ``MOST``
do not count."""


class Plugs(Enum):
    """How motors are plugged in, by what is told of the left wheel, and of the right one."""

    RIGHT = ((1, 0), (0, 1))
    SWAPPED = ((0, 1), (1, 0))
    LEFT_REVERSED = ((-1, 0), (0, 1))
    RIGHT_REVERSED = ((1, 0), (0, -1))
    BOTH_REVERSED = ((-1, 0), (0, -1))
    TURNED_ROUND = ((0, -1), (-1, 0))


WRONG = tuple(plugs for plugs in Plugs if plugs is not Plugs.RIGHT)


class PlugCheck:
    """Follows the tape in sight, and knows how motors seem to be plugged in."""

    def __init__(self, track: float) -> None:
        """Begin with motors that are plugged in rightly.

        Args:
            track: distance between the wheels [m].
        """
        self._track = track
        self._votes = dict.fromkeys(WRONG, 0)
        self._errors = dict.fromkeys(WRONG, 0.0)
        """How far tape is off where any motion lays it rightly; old errors count less [m]."""
        self._last: Pose2 | None = None
        self._stamp = -math.inf
        self.plugs = Plugs.RIGHT
        """How motors are plugged in, as far as is known."""
        self._begin(np.empty((0, 2)))

    def add(self, scan: Scan, odometry: Pose2) -> None:
        """Add a scan, and odometry at its stamp."""
        elapsed, self._stamp = scan.stamp - self._stamp, scan.stamp
        points = near_points(scan)
        last, self._last = self._last, odometry
        if last is None or not 0 < elapsed < LONGEST:
            self._begin(points)
            return
        self._move(last.inverse() @ odometry)
        if self._way > STRIDE:
            if min(len(points), len(self._points)) >= FEWEST:
                self._compare(points)
            self._begin(points)

    def _begin(self, points: Array) -> None:
        self._points = points
        """(n, 2) the tape that later tape is laid on, in the robot's frame then [m]."""
        self._steps: list[Array] = []
        """(2,) ways of the left and the right wheel since then, as they are told [m]."""
        self._way = 0.0

    def _move(self, step: Pose2) -> None:
        half = step.theta / 2
        way = math.hypot(step.x, step.y) * (half / math.sin(half) if abs(half) > 1e-6 else 1.0)
        way = math.copysign(way, step.x * math.cos(half) + step.y * math.sin(half))
        self._steps.append(np.array([way - half * self._track, way + half * self._track]))
        self._way += abs(way) + abs(half) * self._track

    def _motion(self, plugs: Plugs) -> Pose2:
        """Return the robot's motion since then, if motors are plugged in so."""
        motion = Pose2()
        for step in self._steps:
            left, right = (np.array(plugs.value) @ step).tolist()
            twist = Twist2((left + right) / 2, (right - left) / self._track)
            motion = motion @ twist.integrate(1.0)
        return motion

    def _compare(self, points: Array) -> None:
        right = misfit(self._points, self._motion(Plugs.RIGHT), points)
        if right < LIES and not any(self._votes.values()):
            return  # as nearly always
        errors = {plugs: misfit(self._points, self._motion(plugs), points) for plugs in WRONG}
        if min(right, *errors.values()) > LIES:
            return
        other = min(right, misfit(self._points, Pose2(), points))  # it may stand on idle wheels
        for plugs in WRONG:
            self._errors[plugs] += (errors[plugs] - self._errors[plugs]) / MOST
            if errors[plugs] < LIES and other > MISSES:
                self._votes[plugs] = min(self._votes[plugs] + 1, MOST)
            elif errors[plugs] > MISSES:
                self._votes[plugs] = max(self._votes[plugs] - 1, 0)
        most = max(WRONG, key=lambda plugs: (self._votes[plugs], -self._errors[plugs]))
        self.plugs = most if self._votes[most] >= SURE else Plugs.RIGHT
