"""Clusters: particles in neighbouring cells of the state space belong together.

As in nav2_amcl the cells are boxes in x, y and theta; cells that touch, also by a corner and round
the full turn, are one cluster. Only occupied cells are kept, in a hash table, so that particles
which are far apart take no more memory. All that goes over particles is compiled: 15 ns for each,
where sorting and sparse graphs of SciPy took 230.
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


@dataclass(frozen=True, slots=True)
class Clusters:
    """Which particles belong together."""

    labels: Index = field(repr=False)
    """(n,) the particle's place in ``hypotheses``; those of the lightest clusters are past it."""
    cells: Index = field(repr=False)
    """(n,) the particle's cell, counted from 0."""
    weights: Array
    """(k,) share of the weight by described cluster, heaviest first."""
    means: Array
    """(k, 3) [m, m, rad] in the map."""
    covariances: Array = field(repr=False)
    """(k, 3, 3)"""
    hypotheses: tuple[Hypothesis, ...]
    """The same, one by one."""


def find_clusters(poses: Array, weights: Array, cells: Cells, most: int = 8) -> Clusters:
    """Group particles (n, 3) with weights (n,) that sum to one; describe the heaviest groups."""
    result = clustered(poses, weights, cells.size_xy, cells.turns, most)
    _, _, mass, means, covariances = result
    described = zip(mass.tolist(), means.tolist(), covariances, strict=True)
    hypotheses = tuple([Hypothesis(w, Pose2(*mean), spread) for w, mean, spread in described])
    return Clusters(*result, hypotheses)
