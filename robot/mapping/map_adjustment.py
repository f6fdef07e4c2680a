"""Adjusts a drive's path, the robot and the strokes of tape together, by least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot.calibration.adjustment import Adjustment, DriveEstimate, Weights
from robot.calibration.sightings import Sightings
from robot.calibration.wheel_motion import WheelMotion
from robot.description.unknowns import COUNT
from robot.geometry import Array
from robot.mapping.strokes import Strokes

NODE_SD = 1.0
"""Standard deviation of a node before the adjustment [m]: next to nothing. A stroke lies where it
was traced because the path was thought to be there, which says nothing of where it is."""
BEND_SD = 0.03
"""... and of how far a node lies off the middle of its neighbours, farther than it was traced [m]:
few pictures may tell little of one node."""


class MapAdjustment(Adjustment):
    """The least-squares problem of a drive on tape that is not known."""

    def __init__(
        self,
        seen: Sightings,
        motion: WheelMotion,
        strokes: Strokes,
        start: Array,
        covariance: Array,
    ) -> None:
        """Prepare it; strokes are about where they were traced."""
        super().__init__(seen, motion, start, covariance)
        self._strokes = strokes

    def _sightings(self, state: DriveEstimate) -> Sightings:
        return replace(self._seen, tape=self._strokes.moved_by(state.map).edges)

    def _prior(self, state: DriveEstimate, weights: Weights) -> tuple[Array, Array]:
        robot, information = super()._prior(state, weights)
        size = COUNT + len(state.map)
        whole = np.zeros((size, size))
        whole[:COUNT, :COUNT] = information
        whole[range(COUNT, size), range(COUNT, size)] = NODE_SD**-2
        bends = self._strokes.bends
        whole[COUNT:, COUNT:] += bends.T @ bends / BEND_SD**2
        return np.concatenate([robot, state.map]), whole
