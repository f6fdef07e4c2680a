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

from app.features.plausibility.overlay import FEWEST, misfit, near_points
from robot.geometry import Array, Pose2, Twist2
from robot.scan import Scan

STRIDE, SHORT_STRIDE = 0.02, 0.006
"""Tape is compared after each such way [m]; pictures that are late by turns, after the shorter one.
"""
ARM = 0.1
"""A turn counts as a way at this distance [m]."""
LONGEST = 1.0
"""After a longer time without a scan, or one that runs back, comparing begins anew [s]."""
OFF, LIES = 0.005, 0.0015
"""Tape is off by more than this if a picture is late, and by less than this with its lateness [m].
"""
LEAST, LATEST = 0.025, 0.2
"""Smallest and largest change of lateness that is looked for [s]."""
COARSE, FINE = 0.01, 0.002
"""Steps of that search [s]."""
SWINGS, WITHIN = 3, 2.5
"""Pictures are late by turns if lateness swings so often within this time [s]."""
CONFIRMED = 2
"""Lateness has changed for good if so many comparisons after that find it as it is then."""
QUIET = 4.0
"""Pictures are punctual again if lateness has not swung for this long [s]. It is the shortest of
the same time that counts as none."""
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
        self.late = 0.0
        """How much earlier the newest picture was taken than its stamp says [s]."""
        self.habit = Habit.PUNCTUAL
        self.changed = -math.inf
        """Stamp at which lateness last changed [s]."""
        self.twist = Twist2()
        """The robot's velocity by odometry at the newest scan."""
        self._last: tuple[float, Pose2] | None = None
        self._anchor: _Seen | None = None
        self._swings: deque[tuple[float, float]] = deque()
        """Stamps of the last changes, and by how much lateness grew [s]."""
        self._pending: float | None = None
        """Lateness that waits for comparisons that find it again [s]."""
        self._fitting = 0
        self._lately: deque[tuple[float, float]] = deque()
        """Stamps and latenesses while they swing [s]."""
        self._distrusted = -math.inf
        """Until when no change is believed [s]."""

    def add(self, scan: Scan, odometry: Pose2) -> None:
        """Add a scan, and odometry at its stamp."""
        last, self._last = self._last, (scan.stamp, odometry)
        elapsed = math.inf if last is None else scan.stamp - last[0]
        if last is None or not 0 < elapsed < LONGEST:
            self._anchor = None
            return
        step = last[1].inverse() @ odometry
        way = math.copysign(math.hypot(step.x, step.y), step.x)
        self.twist = Twist2(way / elapsed, step.theta / elapsed)
        seen = _Seen(scan.stamp, odometry, self.twist, near_points(scan))
        anchor = self._anchor
        if anchor is None or min(len(seen.points), len(anchor.points)) < FEWEST:
            self._anchor = replace(seen, late=self._assumed)
        elif self._is_stride(anchor, seen):
            self._compare(anchor, seen)
        if self.habit is Habit.BY_TURNS and scan.stamp - self._swings[-1][0] > QUIET:
            self._end(scan.stamp)

    @property
    def _assumed(self) -> float:
        """Lateness that the next picture should have [s]."""
        return self.late if self._pending is None else self._pending

    def _is_stride(self, before: _Seen, after: _Seen) -> bool:
        step = before.odometry.inverse() @ after.odometry
        way = math.hypot(step.x, step.y) + ARM * abs(step.theta)
        return way > (SHORT_STRIDE if self.habit is Habit.BY_TURNS else STRIDE)

    def _compare(self, before: _Seen, after: _Seen) -> None:
        if self.habit is Habit.BY_TURNS:
            late, error = _search(before, after)
            if error < OFF:
                self._note(after.stamp, late - before.late)
                self._follow(after.stamp, late)
            self._anchor = replace(after, late=late if error < OFF else before.late)
            return
        late = self._assumed
        if _error(before, after, late) < OFF:
            self._confirm(after.stamp)
        else:
            late = self._change(before, after)
        self._anchor = replace(after, late=late)

    def _confirm(self, stamp: float) -> None:
        if self._pending is None:
            return
        self._fitting += 1
        if self._fitting >= CONFIRMED:
            self.late = 0.0 if abs(self._pending) < LEAST else self._pending
            self._pending, self.habit, self.changed = None, Habit.LATER, stamp

    def _change(self, before: _Seen, after: _Seen) -> float:
        """Look for another lateness of a picture; return what it is taken for [s]."""
        late, error = _search(before, after)
        grown = late - before.late
        if error > LIES or abs(grown) < LEAST or after.stamp < self._distrusted:
            self._pending = None
            return self.late
        slips = self._pending is not None and grown * self._swings[-1][1] > 0
        if slips:
            self._pending, self._distrusted = None, after.stamp + DISTRUST
            self._swings.clear()
            return self.late
        self._note(after.stamp, grown)
        if len(self._swings) >= SWINGS:
            self._pending, self.habit = None, Habit.BY_TURNS
            self._follow(after.stamp, late)
        else:
            self._pending, self._fitting = late, 0
        return late

    def _note(self, stamp: float, grown: float) -> None:
        """Note how lateness has grown; only changes to and fro are swings."""
        if abs(grown) < LEAST:
            return
        if self._swings and grown * self._swings[-1][1] > 0:
            self._swings.clear()
        self._swings.append((stamp, grown))
        while stamp - self._swings[0][0] > WITHIN:
            self._swings.popleft()

    def _follow(self, stamp: float, late: float) -> None:
        """Follow lateness that swings: the least of the last seconds is none."""
        self._lately.append((stamp, late))
        while stamp - self._lately[0][0] > QUIET:
            self._lately.popleft()
        self.late, self.changed = late - min(each for _, each in self._lately), stamp

    def _end(self, stamp: float) -> None:
        """Begin anew with punctual pictures."""
        self.late, self.habit = 0.0, Habit.PUNCTUAL
        self._anchor = None
        self._swings.clear()
        self._lately.clear()


def _error(before: _Seen, after: _Seen, late: float) -> float:
    """Return how far the tape of a picture that is as late as this [s] is off that before [m]."""
    motion = before.taken_at(before.late).inverse() @ after.taken_at(late)
    return misfit(before.points, motion.apply(after.points))


def _search(before: _Seen, after: _Seen) -> tuple[float, float]:
    """Return the lateness of a picture [s] that lays its tape on that before, and its error [m]."""
    best = before.late, _error(before, after, before.late)
    for reach, step in ((LATEST, COARSE), (COARSE, FINE)):
        steps = round(reach / step)
        tried = best[0] + step * np.arange(-steps, steps + 1)
        best = min(((late, _error(before, after, late)) for late in tried.tolist()), key=_second)
    return best


def _second(pair: tuple[float, float]) -> float:
    return pair[1]
