"""``tape_seen``: tape in the robot's own views: it is forbidden wherever the robot may be."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from robot.geometry import Array, Pose2, heading_vectors
from robot.navigation.possible_places import Glimpse
from robot.scan import Scan

BESIDE_M = 0.05
"""An edge counts that a ray beside it has seen, too, so far from it at most [m]: tape is as wide as
several rays, and what a single one sees is a speck."""
SAME_CELL_M = 0.005
"""Of points in a cell of this side, one is kept [m]."""


def tape_seen(views: Sequence[Glimpse], odom: Pose2) -> Array:
    """Return points (n, 2) [m] of tape that views have seen, in the frame of a robot at ``odom``.

    What hides a part of a ray counts as tape: as a rule it is tape on which the ray begins.
    """
    robot_from_odom = odom.inverse()
    seen = [(robot_from_odom @ view.odom_from_robot).apply(tape_in(view.scan)) for view in views]
    points = np.concatenate(seen) if seen else np.zeros((0, 2))
    _, kept = np.unique(np.rint(points / SAME_CELL_M), axis=0, return_index=True)
    return points[np.sort(kept)]


def tape_in(scan: Scan, *, edges: bool = False) -> Array:
    """Return points (n, 2) [m] of tape in a scan, in the robot's frame.

    Where tape reaches out of what a ray sees, its last visible point counts, or with ``edges`` none
    does.
    """
    count = len(scan.bearings)
    sight = scan.sight if scan.sight is not None else np.tile([0.0, np.inf], (count, 1))
    ways = [scan.ranges]
    if scan.hidden is not None:
        begins, ends = scan.hidden.T
        hides = begins <= ends
        near, far = sight.T
        begins = np.where(begins > near, begins, np.nan if edges else near)
        ends = np.where(ends < far, ends, np.nan if edges else far)
        ways += [np.where(hides, begins, np.inf), np.where(hides, ends, np.inf)]
    directions = heading_vectors(scan.bearings)
    points = [np.zeros((0, 2))]
    for away in ways:
        # A ray without sight is nan, and so False.
        met = np.isfinite(away) & (away >= sight[:, 0]) & (away <= sight[:, 1])
        ends_at = directions * np.where(met, away, np.nan)[:, None]
        beside = np.hypot(*np.diff(ends_at, axis=0).T) <= BESIDE_M
        pair = np.concatenate([beside, [False]]) | np.concatenate([[False], beside])
        points.append(ends_at[met & pair])
    return scan.robot_from_scan.apply(np.concatenate(points))
