"""The camera of the emulated robot: what it exposes when, while the world goes on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sim.floor_camera import CameraSettings
from sim.hat_emulator.picture_server import Shot
from sim.pictures.exposures import Exposures
from sim.pictures.past_poses import PastPoses
from sim.world import World


class CameraFeed:
    """Looks at the world after each of its steps and hands over what was exposed."""

    def __init__(
        self,
        world: World,
        settings: CameraSettings,
        readout: float,
        wall: Callable[[float], float],
        take: Callable[[Shot], None],
    ) -> None:
        """
        Args:
            readout: time from the first row's exposure to the last row's [s].
            wall: from the world's time [s] to CLOCK_MONOTONIC [s].
            take: gets each shot, as soon as its last row was exposed.
        """
        self._world = world
        self._settings = settings
        self._exposures = Exposures(settings, readout, np.random.default_rng(0))
        self._past = PastPoses()
        self._wall = wall
        self._take = take

    def look(self, current: float) -> None:
        """The world has made a step, to ``current`` [s] by its own time."""
        self._past.remember(current, self._world.pose, self._world.twist)
        exposed = self._exposures.newest(current - self._exposures.until_read)
        if exposed is None:
            return
        pose, twist = self._past.at(exposed)
        stamp = self._wall(exposed + self._settings.stamp_error)
        self._take(Shot(stamp, self._wall(exposed + self._exposures.until_here), pose, twist))

    def moved(self, current: float) -> None:
        """The robot was put elsewhere by hand: pictures under way are lost."""
        self._past.forget()
        self._exposures.skip(current)
