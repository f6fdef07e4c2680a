"""The poses of a drive with the scans that were taken there: nodes of the pose graph."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from robot.geometry import Array, Pose2
from robot.mapping.graph.branch_and_bound import Window, best_pose
from robot.mapping.graph.constraints import Constraint
from robot.mapping.graph.likelihood_pyramid import LikelihoodPyramid
from robot.mapping.graph.point_to_line import ScanAlignment, match_scans
from robot.mapping.graph.pose_graph import PoseGraph
from robot.mapping.graph.surfaces import Surfaces
from robot.scan import evenly

MATCH_GATE_M = 0.3
"""Largest distance of points that belong together when scans are matched [m]."""
FEWEST = 10
"""A scan tells where the robot is if at least this many of its beams met something."""
MOST_POINTS = 150
"""How many points of a scan are compared with a field."""
LEAST_SHARE = 0.6
"""Share of the points in sight of both scans that have to lie on each other."""
LEAST_COMMON = 0.25
"""Share of a scan's points that have to lie on the other scan."""


class KeyFrames:
    """A pose graph whose nodes have scans."""

    def __init__(self, start: Pose2, surfaces: Surfaces) -> None:
        """Begin with a first scan."""
        self.graph = PoseGraph(start)
        self.surfaces = [surfaces]

    def __len__(self) -> int:
        return len(self.surfaces)

    def add(self, pose: Pose2, surfaces: Surfaces) -> int:
        """Add a scan, and return its node."""
        self.surfaces.append(surfaces)
        return self.graph.add_pose(pose)

    def forget_from(self, node: int) -> None:
        """Forget a node and all after it, with what was measured of them."""
        del self.surfaces[node:]
        self.graph.poses = self.graph.poses[:node]
        self.graph.keep_constraints([each for each in self.graph.constraints if each.end < node])

    def telling(self, nodes: Iterable[int]) -> list[int]:
        """Return those nodes whose scans have enough points."""
        return [node for node in nodes if len(self.surfaces[node]) >= FEWEST]

    def field(self, nodes: Iterable[int], levels: int) -> LikelihoodPyramid:
        """Return the likelihood field of some scans, of which there has to be at least one."""
        graph = self.graph
        return LikelihoodPyramid(
            (self.surfaces[node].lines(graph.pose(node)) for node in nodes), levels
        )

    def points(self, nodes: Iterable[int], node: int) -> Array:
        """Return points (n, 2) of some scans, seen from a node, evenly thinned [m]."""
        node_from_map = self.graph.pose(node).inverse()
        points = np.vstack(
            [(node_from_map @ self.graph.pose(k)).apply(self.surfaces[k].points) for k in nodes]
        )
        return points[evenly(len(points), MOST_POINTS)]

    def constraint(self, begin: int, end: int, pose: Pose2, gate: float) -> Constraint | None:
        """Match the scan of a node, supposed at a pose of the map, with that of another.

        Return what that measures, or None if they do not fit.
        """
        supposed = self.graph.pose(begin).inverse() @ pose
        match = match_scans(self.surfaces[end], self.surfaces[begin], supposed, gate)
        if not self._fits(match, end) or match.pose.distance_to(supposed) > gate:
            return None
        return Constraint(begin, end, match.pose, match.information)

    def _fits(self, match: ScanAlignment, node: int) -> bool:
        common = LEAST_COMMON * len(self.surfaces[node])
        return match.share >= LEAST_SHARE and match.fitting >= max(common, FEWEST)


def search(
    frames: KeyFrames, nodes: list[int], points: Array, window: Window, least: float, levels: int
) -> tuple[Pose2, float] | None:
    """Return where points fit the scans of some nodes best, and how well; or None."""
    return best_pose(frames.field(nodes, levels), points, window, least)
