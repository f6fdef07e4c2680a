"""Adjusts a drive's path, the robot and the strokes of tape together, by least squares.

A map as a whole may lie anywhere; only where the robot began says where. Held tightly there, the
first steps would tear when the rest of the map has to turn: strokes move sideways only, so a turn
by degrees is a long way for all of them. So the start is held loosely while the map is adjusted,
and afterwards all of it is moved, as it is, to where it began.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from robot.calibration.adjustment import (
    SAME_COST,
    Adjustment,
    DriveEstimate,
    Solution,
    Weights,
    quality_of,
    step_sd,
)
from robot.calibration.misses import Misses, misses
from robot.calibration.normal_equations import Equations
from robot.calibration.sightings import Sightings
from robot.calibration.wheel_motion import WheelMotion
from robot.description.unknowns import COUNT, PRIORS
from robot.geometry import Array, Pose2, wrap_angle
from robot.mapping.cost_change import cost_change
from robot.mapping.passing import Bridges
from robot.mapping.strokes import Strokes

NODE_SD = 1.0
"""Standard deviation of a node before the adjustment [m]: next to nothing. A stroke lies where it
was traced because the path was thought to be there, which says nothing of where it is. Half of all
numbers of this file: edges of three maps are off by 1.17 mm instead of 1.11; twice: by 1.08
(``python -m benchmarks.constants``)."""
SURE = 2.0
"""If no unknown changes by more than this many of its deviations, the whole step is taken. With 3,
the map of a robot that was far off (generated-37106, 81005) was off by 41 mm instead of 6."""
BEND_SD = 0.03
"""... and of how far a node lies off the middle of its neighbours, farther than it was traced [m]:
few pictures may tell little of one node."""
LEAST_FACTOR = 0.5
"""Errors of the camera do not shrink with the picture's noise: the deviations that were expected
are lowered to this share at most."""
AT_A_TIME = 256
"""Pictures whose derivatives are kept at a time: half a minute of a drive, and 25 MB."""
DERIVATIVES = ("by_pose", "by_unknowns", "map_unknowns", "by_map", "by_pixel")
"""What a long drive has no memory for."""
CURVE_SD = 0.00005
"""Standard deviation of an edge that bends, beside the noise [m]: a spline is not quite as its tape
is, in all pictures alike. Half: 95 % intervals of seven maps hold 94 % of the true edges instead of
95, twice: 97. Of eight more, by known robots, they hold 98 %; twice: 99.9; eight times: 100."""


class MapAdjustment(Adjustment):
    """The least-squares problem of a drive on tape that is not known."""

    def __init__(
        self,
        seen: Sightings,
        motion: WheelMotion,
        strokes: Strokes,
        start: Array,
        covariance: Array,
        bridges: Bridges | None = None,
    ) -> None:
        """Prepare it; strokes are about where they were traced."""
        super().__init__(seen, motion, start, covariance)
        self._strokes = strokes
        self._bridges = bridges or Bridges()

    def _sightings(self, state: DriveEstimate) -> Sightings:
        return replace(self._seen, tape=self._strokes.moved_by(state.map).edges)

    def _add_sightings(
        self,
        equations: Equations,
        sightings: Sightings,
        twists: Array,
        state: DriveEstimate,
        weights: Weights,
        errors: Array | None,
    ) -> Misses:
        """Add some pictures at a time: their derivatives are forgotten once they are added."""
        parts = []
        for first in range(0, len(state.poses), AT_A_TIME):
            some = slice(first, first + AT_A_TIME)
            own = None if errors is None else errors[some]
            part = sightings.part(some.start, some.stop)
            floor = part.floor_points(state.values, twists[some], own)
            seen = misses(part, floor, state.poses[some], state.values, weights.gate)
            sighting = seen.sighting + first * sightings.pixels.shape[1]
            seen = replace(seen, picture=seen.picture + first, sighting=sighting)
            equations.add_sightings(seen, weights.doubt)
            parts.append(_without_derivatives(seen))
        equations.misses = _together(parts)
        return equations.misses

    def _change(self, before: Equations, after: Equations, weights: Weights) -> float:
        return cost_change(before, after, weights)

    def _takes(self, change: float, moves: float) -> bool:
        # Derivatives are not taken at the noise, so the last steps need not lower the cost.
        return change <= 0 or moves < SURE

    def _ends(self, changes: Sequence[tuple[float, float]]) -> bool:
        """Of whole steps only; an edge may come and go for ever, or lie between two lines."""
        last = [change for part, change in changes[-2:] if part == 1]
        is_whole = changes[-1][0] == 1
        return is_whole and min(abs(last[-1]), abs(sum(last))) < SAME_COST

    def _step_errors(self, state: DriveEstimate) -> tuple[Array, Array, Array, Array]:
        """Return errors of the steps, and of the bridges instead of those that they lead over."""
        error, before, after, robot = super()._step_errors(state)
        bridged, wheels_sd = self._bridges.before, step_sd(state.values)
        # There the wheels tell no step: the error is all of the motion.
        apart = error[bridged] * wheels_sd - self._bridges.steps
        apart[:, 2] = wrap_angle(apart[:, 2])
        error[bridged] = apart / self._bridges.sd
        for by_picture in (before, after):
            by_picture[bridged] *= (wheels_sd / self._bridges.sd)[:, :, None]
        before[bridged, :, 3:] = robot[bridged] = 0.0
        return error, before, after, robot

    def _prior(self, state: DriveEstimate, weights: Weights) -> tuple[Array, Array]:
        robot, information = super()._prior(state, weights)
        size = COUNT + len(state.map)
        whole = np.zeros((size, size))
        whole[:COUNT, :COUNT] = information
        whole[range(COUNT, size), range(COUNT, size)] = NODE_SD**-2
        bends = self._strokes.bends
        whole[COUNT:, COUNT:] += bends.T @ bends / BEND_SD**2
        return np.concatenate([robot, state.map]), whole


def _without_derivatives(seen: Misses) -> Misses:
    return replace(
        seen,
        **{name: getattr(seen, name)[:0] for name in DERIVATIVES},
        seen_at=seen.seen_at.copy(),
        ends=seen.ends.copy(),
    )


def _together(parts: Sequence[Misses]) -> Misses:
    """Return the misses of parts of a drive as those of the whole drive."""
    first = parts[0]
    if len(parts) == 1:
        return first
    names = [column.name for column in fields(Misses)]
    return Misses(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    )


def moved_to_start(solution: Solution, strokes: Strokes, start: Array) -> tuple[Solution, Strokes]:
    """Return path and strokes, moved rigidly, so that the robot begins at a pose (3,) [m, rad]."""
    poses = solution.state.poses
    motion = Pose2.from_array(start) @ Pose2.from_array(poses[0]).inverse()
    turned = wrap_angle(poses[:, 2] + motion.theta)
    moved = np.column_stack([motion.apply(poses[:, :2]), turned])
    state = replace(solution.state, poses=moved)
    misses = replace(solution.misses, ends=motion.apply(solution.misses.ends))
    traced = tuple(replace(stroke, nodes=motion.apply(stroke.nodes)) for stroke in strokes.traced)
    return replace(solution, state=state, misses=misses), replace(strokes, traced=traced)


def node_sd(strokes: Strokes, solution: Solution) -> Array:
    """Return how uncertain each node (n,) is across its stroke [m], in the robot's first frame.

    The covariance of the adjustment, by the variance factor of what was seen.
    """
    quality = quality_of(solution, PRIORS)
    # Of no map all that is left over is noise: strokes are not quite as tape is.
    factor = quality.alike_factor * max(LEAST_FACTOR, quality.residual)
    variances = factor**2 * np.diag(solution.covariance)[COUNT:]
    curved = np.repeat(
        [stroke.curved for stroke in strokes.traced],
        [len(stroke.nodes) for stroke in strokes.traced],
    )
    sd: Array = np.sqrt(variances + np.where(curved, CURVE_SD**2, 0.0))
    return sd
