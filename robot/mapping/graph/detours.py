"""Scans that fit somewhere beside the way: the wheels led past that place, and not to it.

Doors and shelves look alike, so a scan may fit a step too far; and a scan that comes late was taken
elsewhere. Either way odometry leads neither to such a place nor back from it, and from the scan
before it to the scan after it as the path does.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from robot.geometry import Pose2, turned_covariance
from robot.mapping.graph.constraints import Constraint
from robot.mapping.graph.key_frames import MATCH_GATE_M, KeyFrames
from robot.mapping.graph.loop_closing import FITTING, OUTLIER
from robot.mapping.graph.pose_graph import PoseGraph

LONGEST = 3
"""Most successive scans beside the way; more of them show where the robot was better than wheels
do."""


class Detour(NamedTuple):
    """Successive nodes that lie beside the way, and where odometry led instead."""

    first: int
    poses: tuple[Pose2, ...]


def detours(graph: PoseGraph) -> Iterator[Detour]:
    """Yield where a path leaves the way that odometry led, and comes back to it."""
    steps = {each.end: each for each in graph.constraints if each.by_odometry}
    squares = graph.squares(list(steps.values())) if steps else np.empty(0)
    ends = [end for end, square in zip(steps, squares.tolist(), strict=True) if square > OUTLIER]
    for first, after in pairwise(sorted(ends)):
        if after - first > LONGEST:
            continue
        way = [steps[node] for node in range(first, after + 1)]
        if float(graph.squares([_joined(way)])[0]) < FITTING:
            poses = [graph.pose(first - 1)]
            for step in way[:-1]:
                poses.append(poses[-1] @ step.moved)
            yield Detour(first, tuple(poses[1:]))


def straighten(frames: KeyFrames) -> dict[int, float]:
    """Match scans beside the way once more, from where odometry led, and adjust the poses.

    Returns:
        How far [m] from where odometry led a scan lies, by its node, if it fits nowhere else.
    """
    graph, doubtful, changed = frames.graph, dict[int, float](), False
    for detour in list(detours(graph)):
        nodes = range(detour.first, detour.first + len(detour.poses))
        others = {
            node: [each.begin for each in graph.constraints if each.end == node] for node in nodes
        }
        new = [
            constraint
            for node, pose in zip(nodes, detour.poses, strict=True)
            for other in frames.telling(sorted({*others[node]} - {*nodes}))
            if (constraint := frames.constraint(other, node, pose, MATCH_GATE_M)) is not None
        ]
        if {each.end for each in new} == {*nodes}:
            kept = [
                each
                for each in graph.constraints
                if each.by_odometry or not {each.begin, each.end} & {*nodes}
            ]
            graph.keep_constraints(kept + new)
            graph.poses[list(nodes)] = [pose.to_array() for pose in detour.poses]
            changed = True
        else:
            for node, pose in zip(nodes, detour.poses, strict=True):
                doubtful[node] = graph.pose(node).distance_to(pose)
    if changed:
        graph.adjust()
    return doubtful


def _joined(way: list[Constraint]) -> Constraint:
    """Return the steps of odometry as one."""
    moved, covariance = Pose2(), np.zeros((3, 3))
    for step in way:
        own = np.asarray(np.linalg.inv(step.information), np.float64)
        covariance += turned_covariance(own, moved.theta)
        moved = moved @ step.moved
    information = np.asarray(np.linalg.inv(covariance), np.float64)
    return Constraint(way[0].begin, way[-1].end, moved, information)
