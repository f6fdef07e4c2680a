"""Rays in the robot's frame, each with its start, its direction and its range."""

from __future__ import annotations

import numpy as np

from robot.geometry import Array
from robot.scan import Scan, evenly


def rays_of(scan: Scan, most: int) -> Array:
    """Return at most ``most`` rays of a scan, evenly spread (n, 9).

    Columns: x, y of the start [m]; direction [rad]; range [m] or +inf; the nearest and the farthest
    distance that the ray sees [m], nan if it sees nowhere; the probability that it returns an edge
    which is there; from where to where something else may hide an edge [m], from inf to -inf if
    there is nothing.
    """
    used = evenly(len(scan.ranges), most)
    rays = np.empty((len(used), 9))
    rays[:, 0], rays[:, 1] = scan.robot_from_scan.x, scan.robot_from_scan.y
    rays[:, 2] = scan.robot_from_scan.theta + scan.bearings[used]
    rays[:, 3] = scan.ranges[used]
    rays[:, 4:6] = (0.0, np.inf) if scan.sight is None else scan.sight[used]
    rays[:, 6] = 1.0 if scan.clear is None else scan.clear[used]
    rays[:, 7:9] = (np.inf, -np.inf) if scan.hidden is None else scan.hidden[used]
    return rays
