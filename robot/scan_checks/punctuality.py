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
from dataclasses import replace
from enum import Enum

from robot.geometry import Pose2, Twist2
from robot.scan import Scan
from robot.scan_checks.lateness_filter import LatenessFilter
from robot.scan_checks.overlay import near_points
from robot.scan_checks.timed_tape import RecentPath, TimedTape

STRIDE = 0.02
"""Tape is compared after each such way [m]."""
ARM = 0.1
"""A turn counts as a way at this distance [m]."""
LONGEST = 1.0
"""After a longer time without a scan, or one that runs back, comparing begins anew [s]."""
OFF, GLIMPSED, LIES, REST = 0.005, 0.003, 0.0015, 0.35
"""Tape is off by more than OFF if a picture is late, or than GLIMPSED before the robot has driven a
whole stride [m]. With its lateness it is off by less than LIES [m], or than that share of it, REST,
and less than OFF."""
LEAST, FARTHEST = 0.025, 0.165
"""A change of lateness that is believed is at least the one and less than the other [s]: the tape
of robots that were stuck is laid on other tape by 0.18."""
SWINGS, WITHIN, LASTS = 3, 2.5, 10.0
"""Pictures are late by turns if lateness swings so often, to and fro, within this time [s]; and are
taken for such until pictures were compared for LASTS [s] in which they have not done so."""
CONFIRMED, PROVES, CHANGE = 2, 0.5, 0.05
"""Lateness has changed for good if so many comparisons after that find it as it is then, and in one
of them the change lays tape by this share nearer to that before it; a smaller change [s] may be a
wheel that has slipped for a moment."""
DISTRUST = 2.0
"""Wheels that slip may do so again for this long [s]: meanwhile no change is believed."""


class Habit(Enum):
    """How pictures come."""

    PUNCTUAL = "punctual"
    LATER = "later"
    BY_TURNS = "by turns"


class Punctuality:
    """Follows how late pictures are, beside how late they were at first."""

    def __init__(self) -> None:
        """Begin with punctual pictures."""
        self.habit = Habit.PUNCTUAL
        """How pictures come."""
        self.changed = -math.inf
        """When they last came later, or swung, in a way that was confirmed [s]."""
        self.doubted = False
        """Whether the newest picture seems later, or earlier, than those before."""
        self.usual = 0.0
        """How much later than the first ones pictures seem to come; slipping wheels look alike [s].
        """
        self.by_turns = LatenessFilter()
        """Of pictures that come late by turns."""
        self._path = RecentPath()
        self._newest: TimedTape | None = None
        self._anchor: TimedTape | None = None
        """The picture with which others are compared."""
        self._last: tuple[float, Pose2] | None = None
        self._swings: deque[tuple[float, float]] = deque()
        """Stamps of the last changes, and by how much lateness grew [s]."""
        self._pending: float | None = None
        """Lateness that waits for pictures that prove it [s]."""
        self._before: TimedTape | None = None
        """The picture before that change."""
        self._fitting, self._proven = 0, False
        self._grown = 0.0
        """By how much later than those before the newest picture seems to be, if it is doubted [s].
        """
        self._distrusted = -math.inf
        """Until when no change is believed [s]."""
        self._even = 0.0
        """For how long pictures were compared since lateness last swung [s]."""

    @property
    def unsure(self) -> float:
        """By how much the newest picture may be later or earlier than reckoned, 1 sd [s].

        Of a change that waits to be confirmed it is all of the change.
        """
        if self.habit is Habit.BY_TURNS:
            return self.by_turns.sd
        return max(abs(self._assumed - self.usual), abs(self._grown))

    def since(self, late: float) -> Pose2:
        """Return where the robot was when the newest picture was taken, seen from its stamp.

        Args:
            late: how much earlier than its stamp that was [s].
        """
        newest = self._newest
        return newest.odometry.inverse() @ newest.taken_at(late) if newest else Pose2()

    def add(self, scan: Scan, odometry: Pose2) -> None:
        """Add a scan, and odometry at its stamp."""
        self.doubted, self._grown = False, 0.0
        last, self._last = self._last, (scan.stamp, odometry)
        elapsed = math.inf if last is None else scan.stamp - last[0]
        if last is None or not 0 < elapsed < LONGEST:
            self._anchor = self._newest = None
            self._path.clear()
            return
        step = last[1].inverse() @ odometry
        way = math.copysign(math.hypot(step.x, step.y), step.x)
        twist = Twist2(way / elapsed, step.theta / elapsed)
        seen = TimedTape(self._path.add(scan.stamp, odometry), twist, near_points(scan))
        self._newest = seen
        if self.habit is Habit.BY_TURNS:
            self.by_turns.add(seen)
            if self._even > LASTS:
                self._doubt(self.by_turns.late)
                self.habit = Habit.PUNCTUAL
        self._compare(seen)

    def _compare(self, seen: TimedTape) -> None:
        anchor, late = self._anchor, self._assumed
        if anchor is None or _turns(seen.twist) or not seen.can_be_laid_on(anchor):
            self._anchor = replace(seen, late=late)
        elif _is_stride(anchor, seen):
            self._even += seen.stamp - anchor.stamp
            if seen.error(anchor, late) < OFF:
                self._confirm(seen)
                late = self._assumed
            else:
                late = self._change(anchor, seen)
            self._anchor = replace(seen, late=late)
        elif self._pending is None and seen.error(anchor, late) > GLIMPSED:
            other = self._search(anchor, seen)
            if other is not None:
                self._doubt(other - anchor.late)

    @property
    def _assumed(self) -> float:
        """Lateness that the next picture should have [s]."""
        return self.usual if self._pending is None else self._pending

    def _doubt(self, grown: float) -> None:
        self.doubted, self._grown = True, grown

    def _confirm(self, seen: TimedTape) -> None:
        """Confirm a change: pictures are as late as each other, and the tape before it tells so."""
        pending, before = self._pending, self._before
        if pending is None or before is None:
            return
        self._fitting += 1
        if seen.can_be_laid_on(before):
            # By each other alone, pictures after a change would fit as well without it.
            changed, same = seen.error(before, pending), seen.error(before, self.usual)
            self._proven |= changed <= PROVES * same
        if self._fitting < CONFIRMED:
            return
        self._pending = None
        if not self._proven:
            return
        grown = pending - self.usual
        if abs(grown) > CHANGE and self.habit is not Habit.BY_TURNS:
            self.habit, self.changed = Habit.LATER, seen.stamp
            self._doubt(grown)  # from this picture on it is reckoned with
        self.usual = pending

    def _search(self, before: TimedTape, after: TimedTape) -> float | None:
        """Return another lateness of a picture [s] that lays its tape on that before."""
        late, error = after.search(before)
        lies = error <= max(LIES, REST * after.error(before, self._assumed)) and error < OFF
        # At the end of what is searched, tape is nearest to other tape that came into sight.
        believed = LEAST <= abs(late - before.late) < FARTHEST and after.stamp >= self._distrusted
        return late if lies and believed else None

    def _change(self, before: TimedTape, after: TimedTape) -> float:
        """Look for another lateness of a picture; return what it is taken for [s]."""
        late = self._search(before, after)
        if late is None:
            self._pending = None
            return self.usual
        grown = late - before.late
        if self._pending is not None and grown * self._swings[-1][1] > 0:  # as wheels slip
            self._pending, self._distrusted = None, after.stamp + DISTRUST
            self._swings.clear()
            return self.usual
        self._pending, self._before, self._fitting, self._proven = late, before, 0, False
        self._doubt(grown)
        self._swings.append((after.stamp, grown))
        while after.stamp - self._swings[0][0] > WITHIN:
            self._swings.popleft()
        to_and_fro = len({grown > 0 for _, grown in self._swings}) == 2
        if len(self._swings) >= SWINGS and to_and_fro:
            if self.habit is not Habit.BY_TURNS:
                self.by_turns = LatenessFilter()
            self.habit, self.changed, self._even = Habit.BY_TURNS, after.stamp, 0.0
        return late


def _turns(twist: Twist2) -> bool:
    """Return whether a robot turns rather than drives: other tape is in sight after each picture.

    Then a corner or a stroke that comes into sight is easily taken for what was seen before.
    """
    return ARM * abs(twist.omega) > abs(twist.v)


def _is_stride(before: TimedTape, after: TimedTape) -> bool:
    step = before.odometry.inverse() @ after.odometry
    return math.hypot(step.x, step.y) + ARM * abs(step.theta) > STRIDE
