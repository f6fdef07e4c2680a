"""Clusters: particles in neighbouring cells of the state space belong together.

As in nav2_amcl the cells are boxes in x, y and theta; cells that touch, also by a corner and round
the full turn, are one cluster.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from robot.geometry import Array, mean_pose, pose_covariance
from robot.localization.estimate import Hypothesis

_NEIGHBOURS = np.array([step for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]).T
"""Half of the 26 cells around one (3, 13): the other half are neighbours the other way."""


@dataclass(frozen=True, slots=True)
class Cells:
    """A partition of the state space into boxes."""

    size_xy: float
    """[m]"""
    turns: int
    """Boxes in a full turn."""

    def of(self, poses: Array) -> NDArray[np.int64]:
        """Cell (n, 3) of each pose, counted from the lowest occupied one; theta from 0."""
        xy = np.floor(poses[:, :2] / self.size_xy).astype(np.int64)
        theta = np.floor((poses[:, 2] + np.pi) * (self.turns / (2 * np.pi))).astype(np.int64)
        return np.column_stack([xy - xy.min(axis=0), theta % self.turns])

    def occupied(self, poses: Array) -> int:
        """How many cells have a pose (n, 3) in them."""
        cells = self.of(poses)
        shape = cells.max(axis=0) + 1
        return len(np.unique(np.ravel_multi_index(tuple(cells.T), tuple(shape))))


@dataclass(frozen=True, slots=True)
class Clusters:
    """Which particles belong together."""

    labels: NDArray[np.int64]
    """(n,) the particle's place in ``hypotheses``; those of the lightest clusters are past it."""
    hypotheses: tuple[Hypothesis, ...]
    """Heaviest first."""


def find_clusters(poses: Array, weights: Array, cells: Cells, most: int = 8) -> Clusters:
    """Group particles (n, 3) with weights (n,) that sum to one; describe the heaviest groups."""
    labels, count = _connected(cells.of(poses), cells.turns)
    mass = np.bincount(labels, weights, count)
    order = np.argsort(-mass, kind="stable")
    place = np.empty(count, dtype=np.int64)
    place[order] = np.arange(count)
    labels = place[labels]
    described = [w for w in range(min(most, count)) if mass[order[w]] > 0]
    found = [_describe(poses[labels == w], weights[labels == w]) for w in described]
    return Clusters(labels, tuple(found))


def _describe(poses: Array, weights: Array) -> Hypothesis:
    mean = mean_pose(poses, weights)
    covariance = pose_covariance(poses, weights, mean)
    # The mean is the particles' own: fewer of them lie closer to it than to the true one.
    independent = 1 - float(np.square(weights / weights.sum()).sum())
    return Hypothesis(float(weights.sum()), mean, covariance / max(independent, 0.5))


def _connected(index: NDArray[np.int64], turns: int) -> tuple[NDArray[np.int64], int]:
    """Cluster of each particle in cells (n, 3), counted from 0, and their number.

    Only occupied cells are looked at: a box around particles that are far apart would not fit into
    memory.
    """
    inner = np.add(index, (1, 1, 0))  # so that neighbours across the border are cells, too
    width, height, _ = (inner.max(axis=0) + 2).tolist()
    shape = (width, height, turns)
    keys, of_particle = np.unique(np.ravel_multi_index(tuple(inner.T), shape), return_inverse=True)
    x, y, theta = np.unravel_index(keys, shape)
    dx, dy, turn = _NEIGHBOURS[:, :, None]
    beside = np.ravel_multi_index((x + dx, y + dy, (theta + turn) % turns), shape)
    place = np.searchsorted(keys, beside).clip(max=len(keys) - 1)
    direction, cell = np.nonzero(keys[place] == beside)
    touching = (np.ones(len(cell), dtype=bool), (cell, place[direction, cell]))
    graph = coo_array(touching, shape=(len(keys), len(keys)))
    count, labels = connected_components(graph, directed=False)
    return labels[of_particle].astype(np.int64), int(count)
