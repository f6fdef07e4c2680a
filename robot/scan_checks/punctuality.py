"""Punctuality of pictures: how much earlier one was taken than its stamp says, beside others.

The tape that is seen now lies on that seen a moment before, moved by what the wheels say. If a
picture was taken earlier than it is stamped, tape lies where it was then: moved by the robot's
velocity for that time. Slipping wheels look alike for a moment, but they slip for about a second,
always to the same side. A picture that is late is followed by one that is not, or by others that
are as late.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from robot.geometry import Array, Pose2, Twist2
from robot.scan import Scan
from robot.scan_checks.overlay import FEWEST, misfit, near_points

STRIDE = 0.02
"""Tape is compared after each such way [m]."""
ARM = 0.1
"""A turn counts as a way at this distance [m]."""
LONGEST = 1.0
"""After a longer time without a scan, or one that runs back, comparing begins anew [s]."""
OFF, LIES = 0.005, 0.0015
"""Tape is off by more than this if a picture is late, and by less than this with its lateness [m].
"""
LEAST, LATEST, STEP = 0.025, 0.2, 0.01
"""Smallest and largest change of lateness that is looked for, and the steps of the search [s]."""
SWINGS, WITHIN = 3, 2.5
"""Pictures are late by turns if lateness swings so often within this time [s]."""
CONFIRMED, CHANGE = 2, 0.05
"""Lateness has changed for good if so many comparisons after that find it as it is then; a smaller
change [s] may be a wheel that has slipped for a moment."""
DISTRUST = 2.0
"""Wheels that slip may do so again for this long [s]: meanwhile no change is believed."""


class Habit(Enum):
    """How pictures come."""

    PUNCTUAL = "punctual"
    LATER = "later"
    BY_TURNS = "by turns"


@dataclass(frozen=True, slots=True, eq=False)
class _Seen:
    stamp: float
    odometry: Pose2
    twist: Twist2
    points: Array
    """(n, 2) [m], in the robot's frame when the picture was taken."""
    late: float = 0.0
    """How much earlier it was taken than its stamp says [s]."""

    def taken_at(self, late: float) -> Pose2:
        """Return where odometry was when the picture was taken, if it was as late as this [s]."""
        return self.odometry @ self.twist.integrate(-late)


class Punctuality:
    """Follows how late pictures are, beside how late they were at first."""

    def __init__(self) -> None:
        """Begin with punctual pictures."""
        self.habit = Habit.PUNCTUAL
        """How pictures came when their lateness last changed."""
        self.changed = -math.inf
        """When that was [s]."""
        self.doubted = False
        """Whether the newest picture seems later, or earlier, than those before."""
        self._late = 0.0
        """How late pictures usually are [s]."""
        self._last: tuple[float, Pose2] | None = None
        self._anchor: _Seen | None = None
        self._swings: deque[tuple[float, float]] = deque()
        """Stamps of the last changes, and by how much lateness grew [s]."""
        self._pending: float | None = None
        """Lateness that waits for comparisons that find it again [s]."""
        self._fitting = 0
        self._distrusted = -math.inf
        """Until when no change is believed [s]."""

    def add(self, scan: Scan, odometry: Pose2) -> None:
        """Add a scan, and odometry at its stamp."""
        self.doubted = False
        last, self._last = self._last, (scan.stamp, odometry)
        elapsed = math.inf if last is None else scan.stamp - last[0]
        if last is None or not 0 < elapsed < LONGEST:
            self._anchor = None
            return
        step = last[1].inverse() @ odometry
        way = math.copysign(math.hypot(step.x, step.y), step.x)
        twist = Twist2(way / elapsed, step.theta / elapsed)
        seen = _Seen(scan.stamp, odometry, twist, near_points(scan))
        anchor = self._anchor
        if anchor is None or min(len(seen.points), len(anchor.points)) < FEWEST:
            self._anchor = replace(seen, late=self._assumed)
        elif _is_stride(anchor, seen):
            late = self._assumed
            if _error(anchor, seen, late) < OFF:
                self._confirm(seen.stamp)
            else:
                late = self._change(anchor, seen)
            self._anchor = replace(seen, late=late)

    @property
    def _assumed(self) -> float:
        """Lateness that the next picture should have [s]."""
        return self._late if self._pending is None else self._pending

    def _confirm(self, stamp: float) -> None:
        if self._pending is None:
            return
        self._fitting += 1
        if self._fitting >= CONFIRMED:
            swings = self.habit is Habit.BY_TURNS and stamp - self.changed < WITHIN
            if abs(self._pending - self._late) > CHANGE and not swings:
                self.habit, self.changed = Habit.LATER, stamp
            self._late, self._pending = self._pending, None

    def _change(self, before: _Seen, after: _Seen) -> float:
        """Look for another lateness of a picture; return what it is taken for [s]."""
        late, error = _search(before, after)
        grown = late - before.late
        if error > LIES or abs(grown) < LEAST or after.stamp < self._distrusted:
            self._pending = None
            return self._late
        if self._pending is not None and grown * self._swings[-1][1] > 0:  # as wheels slip
            self._pending, self._distrusted = None, after.stamp + DISTRUST
            self._swings.clear()
            return self._late
        self._pending, self._fitting, self.doubted = late, 0, True
        self._swings.append((after.stamp, grown))
        while after.stamp - self._swings[0][0] > WITHIN:
            self._swings.popleft()
        if len(self._swings) >= SWINGS:
            self.habit, self.changed = Habit.BY_TURNS, after.stamp
        return late


def _is_stride(before: _Seen, after: _Seen) -> bool:
    step = before.odometry.inverse() @ after.odometry
    return math.hypot(step.x, step.y) + ARM * abs(step.theta) > STRIDE


def _error(before: _Seen, after: _Seen, late: float) -> float:
    """Return how far the tape of a picture that is as late as this [s] is off that before [m]."""
    motion = before.taken_at(before.late).inverse() @ after.taken_at(late)
    return misfit(before.points, motion, after.points)


def _search(before: _Seen, after: _Seen) -> tuple[float, float]:
    """Return the lateness of a picture [s] that lays its tape on that before, and its error [m]."""
    tried = before.late + np.arange(-LATEST, LATEST + STEP / 2, STEP)
    errors = [_error(before, after, late) for late in tried.tolist()]
    best = int(np.argmin(errors))
    return float(tried[best]), errors[best]
