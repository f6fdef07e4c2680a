"""Keeps a map in the frame of its start while it is adjusted.

A map as a whole may lie anywhere; only where the robot began says where. Held tightly there, the
first steps would tear when the rest of the map has to turn: strokes move sideways only, so a turn
by degrees is a long way for all of them. So the start is held loosely while the map is adjusted,
and afterwards all of it is moved, as it is, to where it began.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot.calibration.adjustment import Solution
from robot.geometry import Array, Pose2, wrap_angle
from robot.mapping.strokes import Strokes


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
