"""Times at which a camera with a fixed frame rate exposes and delivers its pictures."""

from __future__ import annotations

import numpy as np

from sim.floor_camera import CameraSettings
from sim.pictures.losses import Losses


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
        self._until_read = settings.exposure / 2 + readout / 2
        self._until_here = self._until_read + settings.delay
        self._losses = Losses(settings, rng)
        self._next = 0

    @property
    def until_read(self) -> float:
        """Time from the stamp (the middle of the exposure) until the last row is exposed [s]."""
        return self._until_read

    @property
    def until_here(self) -> float:
        """Time from the stamp until the picture is in memory [s]."""
        return self._until_here

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
