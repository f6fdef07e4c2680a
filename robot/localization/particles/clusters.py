"""Clusters: particles in neighbouring cells of the state space belong together.

As in nav2_amcl, cells are boxes in x, y and theta. Cells that touch belong to one cluster; they may
touch by a corner, and across the end of a full turn. Only occupied cells are kept, in a hash table,
so particles that are far apart take no more memory. The loop over particles is compiled and takes
15 ns for each; sorting and sparse graphs of SciPy took 230.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.kernels.clustering import clustered

Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Cells:
    """A partition of the state space into boxes."""

    size_xy: float
    """[m]"""
    turns: int
    """Boxes in a full turn."""


@dataclass(frozen=True, slots=True, eq=False)
class Clusters:
    """Which particles belong together."""

    labels: Index = field(repr=False)
    """(n,) index of the particle's cluster in ``hypotheses``; larger for the lightest clusters."""
    cells: Index = field(repr=False)
    """(n,) the particle's cell, counted from 0."""
    weights: Array
    """(k,) share of the weight in each described cluster, heaviest first."""
    means: Array
    """(k, 3) [m, m, rad] in the map."""
    covariances: Array = field(repr=False)
    """(k, 3, 3)"""
    hypotheses: tuple[Hypothesis, ...]
    """The described clusters as hypotheses."""


def find_clusters(poses: Array, weights: Array, cells: Cells, most: int = 8) -> Clusters:
    """Group particles (n, 3) with weights (n,) that sum to one; describe the heaviest groups."""
    result = clustered(poses, weights, cells.size_xy, cells.turns, most)
    _, _, mass, means, covariances = result
    described = zip(mass.tolist(), means.tolist(), covariances, strict=True)
    hypotheses = tuple([Hypothesis(w, Pose2(*mean), spread) for w, mean, spread in described])
    return Clusters(*result, hypotheses)
