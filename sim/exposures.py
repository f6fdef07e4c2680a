"""Times at which a camera exposes and delivers its pictures, and which of them are lost."""

from __future__ import annotations

import numpy as np

from sim.floor_camera import CameraSettings

GAP_EVERY = 15.0
"""Each interval of this length has one gap [s]."""


class Losses:
    """Decides for one picture after the other whether it is lost.

    Bursts are a Markov chain of two states. After a picture that arrives, a burst of lost pictures
    begins with the probability that gives the set share of lost pictures. After a lost picture, the
    burst ends with the probability of one over its mean length in pictures.
    """

    def __init__(self, settings: CameraSettings, rng: np.random.Generator) -> None:
        self._gap, self._rng = settings.gap, rng
        share = settings.lost_share
        burst = max(settings.lost_burst * settings.frame_rate, 1.0)
        if share > 0.5:  # shorter bursts cannot give such a share
            burst = max(burst, share / (1 - share))
        self._ends = 1 / burst
        self._begins = share / (1 - share) / burst
        self._in_burst = bool(share > 0 and rng.random() < share)
        self._stretch = -1
        self._gap_begins = 0.0

    def lost(self, stamp: float) -> bool:
        """Whether the next picture, exposed at a stamp [s], is lost."""
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


class Exposures:
    """Stamps of a camera's pictures; each is returned once, or never if a newer one replaces it."""

    def __init__(self, settings: CameraSettings, readout: float, rng: np.random.Generator) -> None:
        """
        Args:
            settings: frame rate, exposure time, delay, and share of lost pictures.
            readout: time from the first row's exposure to the last row's [s].
            rng: draws which pictures are lost.
        """
        self._rate = settings.frame_rate
        self.until_read = settings.exposure / 2 + readout / 2
        """Time from the stamp (the middle of the exposure) until the last row is exposed [s]."""
        self.until_here = self.until_read + settings.delay
        """Time from the stamp until the picture is in memory [s]."""
        self._losses = Losses(settings, rng)
        self._next = 0

    def near(self, stamp: float, margin: float) -> bool:
        """Whether there is a picture's stamp within a margin [s] of a stamp."""
        pictures = stamp * self._rate
        return abs(pictures - round(pictures)) <= margin * self._rate

    def newest(self, until: float) -> float | None:
        """Return the newest stamp up to a time [s] that was not returned before, or None."""
        newest = None
        while self._next / self._rate <= until + 1e-9:
            stamp = self._next / self._rate
            newest = newest if self._losses.lost(stamp) else stamp
            self._next += 1
        return newest

    def skip(self, until: float) -> None:
        """Drop all stamps up to a time [s]."""
        self._next = int(until * self._rate) + 1
