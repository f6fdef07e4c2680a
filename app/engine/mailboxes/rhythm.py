"""Rhythm: chooses so many moments a second of those that come."""

from __future__ import annotations

import math

EARLY_S = 0.02
"""A moment that comes so much too early is chosen [s]: the robot's next tick would be later than it
is early. The mean rate stays what it shall be, as the next one is due as if this one were not."""


class Rhythm:
    """When the next moment is due; one thread uses it."""

    def __init__(self) -> None:
        self._due = -math.inf

    def wait(self, stamp: float) -> float:
        """Return the time from a moment until the next is due [s]; zero or less: it is due."""
        return self._due - EARLY_S - stamp

    def choose(self, stamp: float, rate: float) -> None:
        """Choose a moment, due or not; the next is due by the rate [1/s], which may be inf."""
        period = 1 / rate
        self._due = min(max(self._due, stamp - period), stamp + EARLY_S) + period
