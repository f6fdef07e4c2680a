"""Follows a robot from scan to scan: each is laid on a local map of the last ones."""

from __future__ import annotations

import numpy as np

from robot.geometry import Array, Pose2, turned_covariance
from robot.localization.models.motion_models import MotionModel
from robot.mapping.graph.branch_and_bound import NOWHERE, Window, best_pose
from robot.mapping.graph.constraints import Constraint
from robot.mapping.graph.key_frames import MATCH_GATE_M, KeyFrames
from robot.mapping.graph.likelihood_pyramid import CELL
from robot.mapping.graph.surfaces import Surfaces

LOCAL = 10
"""How many scans the local map is made of."""
LEVELS = 4
"""Resolutions of its field."""
NEIGHBOURS = 4
"""How many of these are matched one by one."""
SURE = 0.5
"""A fit on the local map below this is looked for farther away, too: odometry may have jumped."""
JUMP = np.array([1.5, 1.5, 0.8])
"""How far away it is searched for [m, m, rad]."""
PRIOR_SD = np.array([0.01, 0.01, 0.01])
"""Least standard deviations of odometry [m, m, rad]."""


def track(frames: KeyFrames, moved: Pose2, motion: MotionModel, surfaces: Surfaces) -> None:
    """Add a scan after a motion by odometry, and what it measures of the last ones."""
    last, graph = len(frames) - 1, frames.graph
    _, covariance = motion.moments(moved)
    information = np.asarray(np.linalg.inv(covariance + np.diag(PRIOR_SD**2)), np.float64)
    predicted = graph.pose(last) @ moved
    node = frames.add(predicted, surfaces)
    driven = Constraint(last, node, moved, information, by_odometry=True)
    graph.add_constraints([driven])
    local = frames.telling(range(max(0, node - LOCAL), node))
    if not local or not frames.telling([node]):
        return
    supposed = _on_local_map(frames, local, node, covariance)
    constraints = _matches(frames, local, node, supposed)
    graph.add_constraints(constraints)
    fitting = [*constraints, driven] if constraints else []
    graph.poses[node] = _fused(frames, fitting, supposed).to_array()


def _on_local_map(frames: KeyFrames, local: list[int], node: int, covariance: Array) -> Pose2:
    """Return where a scan lies on the last ones; where it was predicted if it lies nowhere."""
    predicted, before = frames.graph.pose(node), frames.graph.pose(node - 1)
    field, points = frames.field(local, LEVELS), frames.points([node], node)
    spread = np.sqrt(np.diag(turned_covariance(covariance, before.theta)))
    spread[:2] = spread[:2].max()
    spread += CELL
    spread[2] = max(spread[2] - CELL, 0.01)
    best = best_pose(field, points, Window(predicted, 3 * spread, 1 / spread), 0.0)
    if best is not None and best[1] >= SURE:
        return best[0]
    wider = [
        best_pose(field, points, Window(pose, JUMP, NOWHERE), SURE) for pose in (predicted, before)
    ]
    fits = [each for each in wider if each is not None]
    return max(fits, key=lambda each: each[1])[0] if fits else predicted


def _matches(frames: KeyFrames, local: list[int], node: int, pose: Pose2) -> list[Constraint]:
    """Return matches with the last scan, and with those that were taken nearest to here."""

    def away(other: int) -> float:
        place = frames.graph.pose(other)
        return place.distance_to(pose) + 2 * abs(place.turn_to(pose))

    nearest = [local[-1], *sorted(local[:-1], key=away)[: NEIGHBOURS - 1]]
    constraints = (frames.constraint(other, node, pose, MATCH_GATE_M) for other in nearest)
    return [constraint for constraint in constraints if constraint is not None]


def _fused(frames: KeyFrames, constraints: list[Constraint], supposed: Pose2) -> Pose2:
    """Return the pose of a node that fits what was measured of it from others."""
    total, pull = 1e-6 * np.eye(3), np.zeros(3)
    for constraint in constraints:
        begin = frames.graph.pose(constraint.begin)
        offset = supposed.offset_to(begin @ constraint.moved)
        information = turned_covariance(constraint.information, begin.theta)
        # One that is off by many deviations is a jump of the odometry.
        weight = 1 / (1 + float(offset @ information @ offset) / 9)
        total += weight * information
        pull += weight * information @ offset
    return Pose2.from_array(supposed.to_array() + np.linalg.solve(total, pull))
