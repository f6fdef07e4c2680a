"""A histogram filter of how late each picture is, where pictures come late by turns.

Each picture is late on its own. The tape of two that follow each other tells how much later one is
than the other, to some milliseconds; that all are late within some range tells where the first is.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robot.geometry import Array
from robot.scan_checks.timed_tape import CHANGES, TimedTape

MEAN, MEAN_SD, SWAYS = 0.04, 0.02, 0.03
"""How late pictures are on average that are late by turns, the standard deviation of that, and by
how much each of them differs from it, 1 sd [s]: none is early, so they are as late as they differ.
"""
EXACT, FARTHEST = 0.001, 0.004
"""Standard deviation of how far tape is off that of the picture before [m]; and the farthest that
counts, as other tape may come into sight."""
_USUAL = np.exp(-0.5 * np.square(CHANGES / SWAYS))


class LatenessFilter:
    """Follows how late the newest picture is."""

    def __init__(self) -> None:
        """Begin without a picture."""
        self._last: TimedTape | None = None
        self._start()

    def _start(self) -> None:
        self._belief: Array = _USUAL / _USUAL.sum()
        """(41,) probability that a picture is by so much later than on average."""

    @property
    def late(self) -> float:
        """How late the newest picture is, as expected [s]."""
        return MEAN + self._difference

    @property
    def sd(self) -> float:
        """Standard deviation of that [s]."""
        variance = float(self._belief @ np.square(CHANGES - self._difference))
        return math.sqrt(variance + MEAN_SD**2)

    @property
    def _difference(self) -> float:
        return float(self._belief @ CHANGES)

    def add(self, tape: TimedTape) -> None:
        """Add the next picture."""
        last, self._last = self._last, tape
        if last is None or not tape.can_be_laid_on(last):
            self._start()
            return
        before = replace(last, late=self.late)
        errors = [tape.error(before, before.late + later) for later in CHANGES.tolist()]
        likelihood = np.exp(-0.5 * np.square(np.minimum(errors, FARTHEST) / EXACT))
        belief = _USUAL * np.convolve(self._belief, likelihood, mode="same")
        self._belief = belief / belief.sum()
