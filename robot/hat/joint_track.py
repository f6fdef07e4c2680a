"""Where one motor's shaft is: reports checked, unwrapped and remembered by the time of sampling."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import NamedTuple

COUNTS = 2**32
"""The motor counts degrees in 32 bits and wraps."""

FASTEST = 1600.0
"""No motor turns faster [degree/s]: a report beyond that is a garbled one."""

LONGEST_STALL = 1.0
"""So long reports may have waited to be read [s]; a motor turns no farther meanwhile."""

SLACK = 8.0
"""What a report may be off beside the fastest turn: counting and jitter of the stamps [degree]."""

MARK_SLACK = 3
"""Relative and absolute position are read one after the other [degree]."""

REFUSED = 5
"""So many reports in a row that fit each other but not the past are a new beginning."""

MEMORY = 1.0
"""How long samples are kept [s]."""


class Sample(NamedTuple):
    """One position."""

    stamp: float
    """When the motor took it, on the program's clock [s]."""
    angle: float
    """[degree], going on over every re-plug, never wrapped."""


class JointTrack:
    """Turns a motor's reports into one continuous angle.

    A motor counts from where it was plugged in. The track goes on where it was, so a robot that
    was unplugged and plugged in again stands where it stood. A digit that is lost on the wire makes
    another number, not an error; so every report is held against the fastest turn and against the
    absolute position that comes with it, which differs from the relative one by a constant.
    """

    def __init__(self) -> None:
        self._samples: deque[Sample] = deque()
        self._count: int | None = None
        """The last count, gone on beyond 32 bits; None when the next is a new beginning."""
        self._mark: int = 0
        """Count minus absolute position, in one turn [degree]."""
        self._odd: list[int] = []
        """Counts that were refused, newest last."""

    @property
    def newest(self) -> Sample | None:
        """The last sample, None before the first."""
        return self._samples[-1] if self._samples else None

    @property
    def angle(self) -> float:
        """The last angle [degree]; 0 before the first."""
        return self._samples[-1].angle if self._samples else 0.0

    @property
    def newest_stamp(self) -> float:
        """When the last sample was taken [s]; minus infinity before the first."""
        return self._samples[-1].stamp if self._samples else -math.inf

    def begin_anew(self) -> None:
        """The motor was unplugged: its next count has nothing to do with the last one."""
        self._count = None
        self._odd.clear()

    def report(self, stamp: float, count: float, absolute: float) -> bool:
        """Take a report; returns whether it was believed.

        Args:
            stamp: when the motor sampled it [s].
            count: relative position [degree], 32 bits.
            absolute: position against the motor's mark, -180 to 179 [degree].
        """
        if not (float(count).is_integer() and float(absolute).is_integer()):
            return False
        current, mark = int(count), (int(count) - int(absolute)) % 360
        if self._count is None or not self._samples:
            return self._start(stamp, current, mark)
        turned = (current - self._count + COUNTS // 2) % COUNTS - COUNTS // 2
        passed = max(stamp - self._samples[-1].stamp, 0.0)
        # Not the count itself: where that wraps, 256 degrees of a turn are missing.
        apart = (self._count + turned - int(absolute) - self._mark + 180) % 360 - 180
        too_far = abs(turned) > FASTEST * passed + SLACK
        if abs(apart) > MARK_SLACK or too_far:
            if not self._has_enough_like(current):
                return False
            if abs(apart) > MARK_SLACK or abs(turned) > FASTEST * LONGEST_STALL:
                return self._start(stamp, current, mark)
            # Reports that waited while the program did not come to read them have one stamp.
        self._count, self._odd = self._count + turned, []
        self._add(stamp, self._samples[-1].angle + turned)
        return True

    def at(self, stamp: float) -> float:
        """The angle [degree] at a moment, interpolated; before and after what is known, the end."""
        if not self._samples:
            return 0.0
        after = bisect_left(self._samples, stamp, key=lambda sample: sample.stamp)
        if after in (0, len(self._samples)):
            return self._samples[min(after, len(self._samples) - 1)].angle
        low, high = self._samples[after - 1], self._samples[after]
        part = (stamp - low.stamp) / (high.stamp - low.stamp)
        return low.angle + part * (high.angle - low.angle)

    def speed(self, span: float) -> float:
        """Mean speed over the last while [degree/s]."""
        if len(self._samples) < 2:
            return 0.0
        last = self._samples[-1]
        first = self._samples[0]
        for sample in reversed(self._samples):
            first = sample
            if sample.stamp <= last.stamp - span:
                break
        passed = last.stamp - first.stamp
        return (last.angle - first.angle) / passed if passed > 0 else 0.0

    def _start(self, stamp: float, count: int, mark: int) -> bool:
        self._count, self._mark, self._odd = count, mark, []
        self._add(stamp, self.angle)
        return True

    def _has_enough_like(self, count: int) -> bool:
        """Remember an odd count; true when enough agree that it is the past that is wrong."""
        if self._odd and abs(count - self._odd[-1]) > FASTEST * 0.02 + SLACK:
            self._odd.clear()
        self._odd.append(count)
        return len(self._odd) >= REFUSED

    def _add(self, stamp: float, angle: float) -> None:
        if not math.isfinite(stamp):
            raise ValueError(f"a sample at {stamp} s")
        if self._samples and stamp <= self._samples[-1].stamp:
            # Two reports of one moment: the later one holds.
            stamp = self._samples.pop().stamp
        self._samples.append(Sample(stamp, angle))
        while self._samples[0].stamp < stamp - MEMORY:
            self._samples.popleft()
