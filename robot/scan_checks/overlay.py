"""Overlay of scans: how far tape that is seen now is off the tape seen before."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.scan import Scan

REACH = 0.7
"""Tape within this is exact enough [m]."""
APART = 0.05
"""Neighbouring returns that are farther apart than this do not lie along one edge [m]."""
FEWEST = 10
"""Fewer returns tell nothing."""
SHARE = 0.6
"""So many of the returns have to lie on earlier ones: others were not in sight then."""


@lru_cache(maxsize=1)
def near_points(scan: Scan) -> Array:
    """Return the returns (n, 2) of a scan that are near, in the robot's frame [m]."""
    points = scan.points()
    return points[np.hypot(points[:, 0], points[:, 1]) < REACH]


def misfit(before: Array, motion: Pose2, after: Array) -> float:
    """Return how far points (m, 2) are off the tape along earlier ones (n, 2) [m].

    Args:
        before: the earlier ones, in the robot's frame then [m].
        motion: the robot's motion since then.
        after: in the robot's frame after that [m].
    """
    return float(_misfit(before, motion.x, motion.y, motion.theta, after))


@compiled()
def _misfit(before: Array, x: float, y: float, theta: float, after: Array) -> float:
    edges = np.empty((len(before) - 1, 5))
    for i in range(len(edges)):
        along_x, along_y = before[i + 1, 0] - before[i, 0], before[i + 1, 1] - before[i, 1]
        squared = along_x * along_x + along_y * along_y
        if squared > APART * APART:  # a point instead of an edge
            along_x = along_y = squared = 0.0
        edges[i, 0], edges[i, 1] = before[i, 0], before[i, 1]
        edges[i, 2], edges[i, 3], edges[i, 4] = along_x, along_y, 1.0 / max(squared, 1e-12)
    c, s = math.cos(theta), math.sin(theta)
    distances = np.empty(len(after))
    for j in range(len(after)):
        u = x + c * after[j, 0] - s * after[j, 1]
        v = y + s * after[j, 0] + c * after[j, 1]
        nearest = np.inf
        for i in range(len(edges)):
            right, up = u - edges[i, 0], v - edges[i, 1]
            part = (right * edges[i, 2] + up * edges[i, 3]) * edges[i, 4]
            part = min(max(part, 0.0), 1.0)
            right -= part * edges[i, 2]
            up -= part * edges[i, 3]
            nearest = min(nearest, right * right + up * up)
        distances[j] = math.sqrt(nearest)
    distances.sort()
    rank = SHARE * (len(distances) - 1)
    below = int(rank)
    above = min(below + 1, len(distances) - 1)
    return float(distances[below] + (rank - below) * (distances[above] - distances[below]))
