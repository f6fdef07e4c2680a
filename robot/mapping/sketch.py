"""A sketch: the map as far as it is drawn, for people to look at while the robot drives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.calibration.adjustment import Solution
from robot.geometry import Array, Pose2
from robot.mapping.map_adjustment import node_sd
from robot.mapping.pushed import moved_at
from robot.mapping.strokes import Stroke, Strokes

MOST_POINTS = 1500
"""Most of the points at which edges were seen."""


@dataclass(frozen=True, eq=False)
class Sketch:
    """Centre lines, path, and where edges were seen; all in the map."""

    lines: tuple[Array, ...]
    """Each (m, 2) [m]; a closed one repeats its first point."""
    sd: Array
    """(s,) how uncertain each line is across, where it is least certain [m]."""
    path: Array
    """(k, 3) of the robot at each picture [m, m, rad]."""
    edges: Array = field(repr=False)
    """(n, 2) some of the points at which edges were seen [m]."""
    stamp: float
    """Of the last picture [s]."""
    moved_at: float | None
    """When the robot first moved otherwise than its wheels tell [s]; None if it never did."""

    @classmethod
    def of(
        cls,
        strokes: Strokes,
        solution: Solution,
        stamps: Array,
        step_errors: Array,
        last: tuple[float, Array | None],
    ) -> Sketch:
        """Return the sketch of an adjustment.

        Args:
            strokes: the tape.
            solution: the adjustment.
            stamps: of all pictures [s]; the later ones need not be in the adjustment.
            step_errors: (k - 1, 3) how far steps are from what the wheels tell, in deviations.
            last: stamp of the last picture [s], and the pose (3,) of the robot there, if it is not
                the last of the adjustment.
        """
        stamp, pose = last
        path, ends = solution.state.poses, solution.misses.ends
        return cls(
            tuple(stroke.points for stroke in strokes.each),
            largest_by_stroke(strokes.each, node_sd(strokes, solution)),
            path if pose is None else np.vstack([path, pose]),
            ends[:: 1 + len(ends) // MOST_POINTS],
            stamp,
            moved_at(step_errors, solution.state.slip, stamps),
        )

    @property
    def pose(self) -> Pose2:
        """Of the robot at the last picture."""
        return Pose2.from_array(self.path[-1])


def largest_by_stroke(strokes: Sequence[Stroke], sd: Array) -> Array:
    """Return the largest value (s,) of each stroke's nodes."""
    first, largest = 0, []
    for stroke in strokes:
        largest.append(float(sd[first : first + len(stroke.nodes)].max()))
        first += len(stroke.nodes)
    return np.array(largest)
