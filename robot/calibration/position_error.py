"""The error of position that follows from what is not known of a robot, in millimetres."""

from __future__ import annotations

import math

import numpy as np

from robot.calibration.misses import Misses
from robot.geometry import Array

FEWEST_EDGES = 20
"""A picture with fewer edges is not looked at."""
LARGEST_SD = 0.1
"""Nor is one whose edges leave the robot's place open by more, for a pixel's error [m]."""


def position_sd(seen: Misses, covariance: Array) -> float:
    """Return the standard deviation of the robot's place, as its unknowns have theirs [m].

    Each picture is laid on the field alone: where it then seems to be taken moves with the
    unknowns. The result is the median of the pictures; nan if none shows enough.

    Args:
        seen: the edges that a drive saw.
        covariance: (15, 15) of the unknowns.
    """
    distances = []
    for picture in np.unique(seen.picture):
        some = seen.picture == picture
        by_pose, by_unknowns = seen.by_pose[some], seen.by_unknowns[some]
        information = by_pose.T @ by_pose
        if some.sum() < FEWEST_EDGES or np.linalg.cond(information) > 1e9:
            continue
        place = np.linalg.inv(information)
        if np.trace(place[:2, :2]) > LARGEST_SD**2:
            continue
        moved = place @ by_pose.T @ by_unknowns
        distances.append(math.sqrt(np.trace((moved @ covariance @ moved.T)[:2, :2])))
    return float(np.median(distances)) if distances else math.nan
