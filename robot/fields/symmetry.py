"""Turns that carry a field onto itself: what looks the same from several places cannot be told."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from robot.fields.edges import lengths, sample
from robot.geometry import Array, Pose2

STEP, TOLERANCE = 0.010, 0.008
"""Edges are compared at points so far apart, which may lie so far off: no more than their half, and
a little [m]."""
FACING = 0.95
"""Least cosine between the sides that edges face."""
FOLDS = (2, 3, 4, 5, 6, 8)
"""Full turns are cut into so many parts, to be tried."""


def symmetries(edges: Array) -> tuple[Pose2, ...]:
    """Every rotation, as a pose in the map, after which edges (n, 4) lie where edges lay.

    Rotations about the edges' centre; none if only a whole turn does it.
    """
    points, normals = sample(edges, STEP)
    weights = lengths(edges)
    middles = (edges[:, :2] + edges[:, 2:]) / 2
    centre = (middles * weights[:, None]).sum(axis=0) / weights.sum()
    tree = cKDTree(points)
    turns = {round(2 * math.pi * part / fold, 9) for fold in FOLDS for part in range(1, fold)}
    kept = []
    for turn in sorted(turns):
        about = Pose2(*centre.tolist()) @ Pose2(theta=turn) @ Pose2(*(-centre).tolist())
        distances, nearest = tree.query(about.apply(points), distance_upper_bound=TOLERANCE)
        if np.isfinite(distances).all():
            turned = Pose2(theta=turn).apply(normals)
            if ((turned * normals[nearest]).sum(axis=1) > FACING).mean() > FACING:
                kept.append(about)
    return tuple(kept)
