"""Angle of one motor's shaft: reports are checked, unwrapped and kept by their sampling time."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import NamedTuple

COUNTS = 2**32
"""The motor counts degrees in 32 bits, and the count wraps."""

FASTEST = 1600.0
"""No motor turns faster [degree/s]; a report of a faster turn is garbled."""

LONGEST_STALL = 1.0
"""Longest time that reports may wait to be read [s]; it limits how far a motor turns meanwhile."""

SLACK = 8.0
"""A report may exceed the fastest turn by this, due to counting and jitter of stamps [degree]."""

MARK_SLACK = 3
"""Tolerance between relative and absolute position, which are read one after the other [degree]."""

REFUSED = 5
"""After this many reports in a row that fit each other but not the past, counting starts again."""

MEMORY = 1.0
"""How long samples are kept [s]."""


class Sample(NamedTuple):
    """One measured angle."""

    stamp: float
    """When the motor measured it, on the program's clock [s]."""
    angle: float
    """[degree], continuous over every re-plug, never wrapped."""


class JointTrack:
    """Turns a motor's reports into one continuous angle.

    A motor counts from the angle at which it was plugged in. The track continues from its last
    angle, so the joints of a robot that was unplugged and plugged in again keep their angles. A
    digit that is lost on the wire makes another number, not an error. So every report is compared
    with the fastest turn, and with the absolute position in the same report, which differs from the
    relative one by a constant.
    """

    def __init__(self) -> None:
        self._samples: deque[Sample] = deque()
        self._count: int | None = None
        """The last count, continued beyond 32 bits; None if counting starts with the next one."""
        self._mark: int = 0
        """Count minus absolute position, within one turn [degree]."""
        self._odd: list[int] = []
        """Refused counts, newest last."""

    @property
    def newest(self) -> Sample | None:
        """The last sample; None before the first."""
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
        """Take note that the motor was unplugged: its next count is unrelated to the last one."""
        self._count = None
        self._odd.clear()

    def report(self, stamp: float, count: float, absolute: float) -> bool:
        """Take a report; return whether it was accepted.

        Args:
            stamp: when the motor sampled it [s].
            count: relative position [degree], 32 bits.
            absolute: position relative to the motor's mark, -180 to 179 [degree].
        """
        if not (float(count).is_integer() and float(absolute).is_integer()):
            return False
        current, mark = int(count), (int(count) - int(absolute)) % 360
        if self._count is None or not self._samples:
            return self._start(stamp, current, mark)
        turned = (current - self._count + COUNTS // 2) % COUNTS - COUNTS // 2
        passed = max(stamp - self._samples[-1].stamp, 0.0)
        # The raw count would not do: where it wraps, 256 degrees of a turn are missing.
        apart = (self._count + turned - int(absolute) - self._mark + 180) % 360 - 180
        too_far = abs(turned) > FASTEST * passed + SLACK
        if abs(apart) > MARK_SLACK or too_far:
            if not self._has_enough_like(current):
                return False
            if abs(apart) > MARK_SLACK or abs(turned) > FASTEST * LONGEST_STALL:
                return self._start(stamp, current, mark)
            # Otherwise the reports had to wait until the program read them, and have one stamp.
        self._count, self._odd = self._count + turned, []
        self._add(stamp, self._samples[-1].angle + turned)
        return True

    def at(self, stamp: float) -> float:
        """Return the angle [degree] at a moment, interpolated; outside the samples, the nearest."""
        if not self._samples:
            return 0.0
        after = bisect_left(self._samples, stamp, key=lambda sample: sample.stamp)
        if after in (0, len(self._samples)):
            return self._samples[min(after, len(self._samples) - 1)].angle
        low, high = self._samples[after - 1], self._samples[after]
        part = (stamp - low.stamp) / (high.stamp - low.stamp)
        return low.angle + part * (high.angle - low.angle)

    def speed(self, span: float) -> float:
        """Return the mean speed [degree/s] over the last ``span`` [s]."""
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
        """Remember a refused count; return whether enough of them agree against the past."""
        if self._odd and abs(count - self._odd[-1]) > FASTEST * 0.02 + SLACK:
            self._odd.clear()
        self._odd.append(count)
        return len(self._odd) >= REFUSED

    def _add(self, stamp: float, angle: float) -> None:
        if not math.isfinite(stamp):
            raise ValueError(f"a sample at {stamp} s")
        if self._samples and stamp <= self._samples[-1].stamp:
            # Of two reports of one moment, the later one is kept.
            stamp = self._samples.pop().stamp
        self._samples.append(Sample(stamp, angle))
        while self._samples[0].stamp < stamp - MEMORY:
            self._samples.popleft()
