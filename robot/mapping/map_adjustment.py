"""Adjusts a drive's path, the robot and the strokes of tape together, by least squares."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot.calibration.adjustment import Adjustment, State, Weights
from robot.calibration.sightings import Sightings
from robot.calibration.unknowns import COUNT
from robot.calibration.wheel_motion import WheelMotion
from robot.geometry import Array
from robot.mapping.strokes import Strokes

NODE_SD = 0.03
"""Standard deviation of a node before the adjustment [m]; few pictures may tell little of it."""


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

    def _sightings(self, state: State) -> Sightings:
        return replace(self._seen, tape=self._strokes.moved_by(state.map).edges)

    def _prior(self, state: State, weights: Weights) -> tuple[Array, Array]:
        robot, information = super()._prior(state, weights)
        size = COUNT + len(state.map)
        whole = np.zeros((size, size))
        whole[:COUNT, :COUNT] = information
        whole[range(COUNT, size), range(COUNT, size)] = NODE_SD**-2
        return np.concatenate([robot, state.map]), whole
