"""Camera of the emulated robot: it exposes pictures while the world moves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from sim.floor_camera import CameraSettings
from sim.hat_emulator.picture_server import Shot
from sim.pictures.exposures import Exposures
from sim.pictures.past_poses import PastPoses
from sim.world import World


class CameraFeed:
    """Records the world's pose after each step, and hands over each exposed shot."""

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
            wall: converts the world's time [s] to CLOCK_MONOTONIC [s].
            take: called with each shot, as soon as its last row is exposed.
        """
        self._world = world
        self._settings = settings
        self._exposures = Exposures(settings, readout, np.random.default_rng(0))
        self._past = PastPoses()
        self._wall = wall
        self._take = take

    def look(self, current: float) -> None:
        """Record the world after a step to ``current`` [s] of its time; hand over a due shot."""
        self._past.remember(current, self._world.pose, self._world.twist)
        exposed = self._exposures.newest(current - self._exposures.until_read)
        if exposed is None:
            return
        pose, twist = self._past.at(exposed)
        stamp = self._wall(exposed + self._settings.stamp_error)
        self._take(Shot(stamp, self._wall(exposed + self._exposures.until_here), pose, twist))

    def moved(self, current: float) -> None:
        """Forget the past, since the robot was placed elsewhere: unfinished pictures are lost."""
        self._past.forget()
        self._exposures.skip(current)
