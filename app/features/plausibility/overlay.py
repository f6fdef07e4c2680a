"""Overlay of scans: how far tape that is seen now is off the tape seen before."""

from __future__ import annotations

import numpy as np

from robot.geometry import Array
from robot.scan import Scan

REACH = 0.7
"""Tape within this is exact enough [m]."""
APART = 0.05
"""Neighbouring returns that are farther apart than this do not lie along one edge [m]."""
FEWEST = 10
"""Fewer returns tell nothing."""
SHARE = 0.6
"""So many of the returns have to lie on earlier ones: others were not in sight then."""


def near_points(scan: Scan) -> Array:
    """Return the returns (n, 2) of a scan that are near, in the robot's frame [m]."""
    points = scan.points()
    return points[np.hypot(points[:, 0], points[:, 1]) < REACH]


def misfit(before: Array, after: Array) -> float:
    """Return how far points (m, 2) are off the tape along others (n, 2) [m]."""
    starts, along = before[:-1], np.diff(before, axis=0)
    along[np.hypot(along[:, 0], along[:, 1]) > APART] = 0.0  # a point instead of an edge
    squared = np.maximum((along**2).sum(axis=1), 1e-12)
    offsets = after[:, None] - starts
    part = np.clip((offsets * along).sum(axis=2) / squared, 0.0, 1.0)
    nearest = offsets - part[..., None] * along
    return float(np.quantile(np.sqrt((nearest**2).sum(axis=2).min(axis=1)), SHARE))
