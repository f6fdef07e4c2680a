"""When a camera of a fixed frame rate exposes, and when a picture of it can be had."""

from __future__ import annotations

import numpy as np

from sim.floor_camera import CameraSettings
from sim.pictures.losses import Losses


class Exposures:
    """The moments of a camera's pictures, each handed out once; one that was overtaken never."""

    def __init__(self, settings: CameraSettings, readout: float, rng: np.random.Generator) -> None:
        """
        Args:
            settings: how often, how long, and how many pictures are lost.
            readout: time from the first row's exposure to the last row's [s].
            rng: decides which pictures are lost.
        """
        self._rate = settings.frame_rate
        self._until_read = settings.exposure / 2 + readout / 2
        self._until_here = self._until_read + settings.delay
        self._losses = Losses(settings, rng)
        self._next = 0

    @property
    def until_read(self) -> float:
        """From the stamp, the middle of the exposure, to the end of the last row's exposure [s]."""
        return self._until_read

    @property
    def until_here(self) -> float:
        """From the stamp until the picture is in memory [s]."""
        return self._until_here

    def newest(self, until: float) -> float | None:
        """The newest stamp [s] up to a moment that was not handed out before, if there is one."""
        newest = None
        while self._next / self._rate <= until + 1e-9:
            stamp = self._next / self._rate
            newest = newest if self._losses.lost(stamp) else stamp
            self._next += 1
        return newest

    def skip(self, until: float) -> None:
        """Hand out none of those up to a moment [s]."""
        self._next = int(until * self._rate) + 1
