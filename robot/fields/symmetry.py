"""Rotations that map a field onto itself: poses that look the same cannot be told apart."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from robot.fields.edges import lengths, sample
from robot.geometry import Array, Pose2

STEP, TOLERANCE = 0.010, 0.008
"""Edges are compared at points STEP apart, which may be off by TOLERANCE [m]: half of STEP and a
little more."""
FACING = 0.95
"""Smallest cosine between the normals of matching points, and smallest share of such points."""
FOLDS = (2, 3, 4, 5, 6, 8)
"""The full turn is divided by each of these numbers; all multiples of the parts are tried."""


def symmetries(edges: Array) -> tuple[Pose2, ...]:
    """Return every rotation, as a pose in the map, that maps edges (n, 4) onto themselves.

    The rotations are about the edges' centre. There are none if only a full turn does it.
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
