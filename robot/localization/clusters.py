"""Clusters: particles in neighbouring cells of the state space belong together.

As in nav2_amcl the cells are boxes in x, y and theta; cells that touch, also by a corner and round
the full turn, are one cluster.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label

from robot.geometry import Array, mean_pose, pose_covariance
from robot.localization.estimate import Hypothesis


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
    return Hypothesis(float(weights.sum()), mean, pose_covariance(poses, weights, mean))


def _connected(index: NDArray[np.int64], turns: int) -> tuple[NDArray[np.int64], int]:
    """Cluster of each particle in cells (n, 3), counted from 0, and their number."""
    width, height = (index[:, :2].max(axis=0) + 1).tolist()
    occupied = np.zeros((width, height, turns), dtype=bool)
    occupied[tuple(index.T)] = True
    labels, count = label(occupied, structure=np.ones((3, 3, 3)))
    merged = _join_round_turn(labels, count)
    found, of_particle = np.unique(merged[labels[tuple(index.T)]], return_inverse=True)
    return of_particle, len(found)


def _join_round_turn(labels: NDArray[np.signedinteger], count: int) -> NDArray[np.int64]:
    """New label of each label, with those that touch across -pi joined."""
    parent = np.arange(count + 1)
    first, last = labels[:, :, 0], labels[:, :, -1]
    if not (first.any() and last.any()):
        return parent
    padded = np.pad(last, 1)
    for dx in range(3):
        for dy in range(3):
            beside = padded[dx : dx + first.shape[0], dy : dy + first.shape[1]]
            touching = (first > 0) & (beside > 0)
            pairs = np.unique(np.column_stack([first[touching], beside[touching]]), axis=0)
            for a, b in pairs:
                root_a, root_b = parent[a], parent[b]
                if root_a != root_b:
                    parent[parent == max(root_a, root_b)] = min(root_a, root_b)
    return parent
