"""Which pictures never arrive: bursts of them (Gilbert 1960), and longer gaps."""

from __future__ import annotations

import numpy as np

from sim.floor_camera import CameraSettings

GAP_EVERY = 15.0
"""One gap lies in each such stretch of time [s]."""


class Losses:
    """Decides for one picture after the other.

    A chain of two states: each picture that arrives is followed by a burst of lost ones with a
    probability such that the share of lost pictures is as set; each burst ends after a picture
    with one over its mean length.
    """

    def __init__(self, settings: CameraSettings, rng: np.random.Generator) -> None:
        self._gap, self._rng = settings.gap, rng
        share = settings.lost_share
        burst = max(settings.lost_burst * settings.frame_rate, 1.0)
        if share > 0.5:  # else it could not arrive so seldom
            burst = max(burst, share / (1 - share))
        self._ends = 1 / burst
        self._begins = share / (1 - share) / burst
        self._in_burst = bool(share > 0 and rng.random() < share)
        self._stretch = -1
        self._gap_begins = 0.0

    def lost(self, stamp: float) -> bool:
        """Whether the next picture, exposed at a stamp [s], never arrives."""
        burst = self._in_burst
        if self._begins > 0:
            chance = self._ends if burst else self._begins
            self._in_burst = burst != (self._rng.random() < chance)
        return burst or self._in_gap(stamp)

    def _in_gap(self, stamp: float) -> bool:
        if self._gap == 0:
            return False
        stretch = int(stamp // GAP_EVERY)
        if stretch != self._stretch:
            self._stretch = stretch
            self._gap_begins = stretch * GAP_EVERY + self._rng.uniform(0, GAP_EVERY - self._gap)
        return 0 <= stamp - self._gap_begins < self._gap
