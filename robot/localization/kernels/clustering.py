"""Particles joined into clusters by their cells, which a hash table finds."""

from __future__ import annotations

import math

import numpy as np
from numba import int64, njit
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.kernels.moments import add_moments, describe

Index = NDArray[np.int64]

NO_WEIGHT = 1e-100
"""Clusters with less are not described: the squares of so small numbers are zero."""


@njit(cache=True, nogil=True)
def clustered(
    poses: Array, weights: Array, size_xy: float, turns: int, most: int
) -> tuple[Index, Index, Array, Array, Array]:
    """Join particles (n, 3) with weights (n,) into clusters.

    Args:
        poses: [m, m, rad] in the map.
        weights: of the particles; they sum to one.
        size_xy: side of a cell [m].
        turns: cells in a full turn.
        most: clusters that are described.

    Returns:
        Cluster (n,) and cell (n,) of each particle; share of the weight (k,), mean (k, 3) and
        covariance (k, 3, 3) of the heaviest clusters.
    """
    cell_of, cells, table = _sort_into_cells(poses, size_xy, turns)
    cluster_of, count = _join_neighbours(cells, table, turns)
    moments = add_moments(poses, weights, cell_of, len(cells))
    mass = np.zeros(count)
    for cell in range(len(cells)):
        mass[cluster_of[cell]] += moments[cell, 0]
    order = np.argsort(-mass, kind="mergesort")
    place = np.empty(count, dtype=np.int64)
    place[order] = np.arange(count)
    for cell in range(len(cells)):
        cluster_of[cell] = place[cluster_of[cell]]
    described = min(most, int((mass > NO_WEIGHT).sum()))
    means, covariances = describe(moments, cluster_of, described)
    labels = np.empty(len(poses), dtype=np.int64)
    for i in range(len(poses)):
        labels[i] = cluster_of[cell_of[i]]
    return labels, cell_of, mass[order[:described]], means, covariances


@njit(cache=True, nogil=True)
def _sort_into_cells(
    poses: Array, size_xy: float, turns: int
) -> tuple[Index, Index, NDArray[np.int32]]:
    """Cell (n,) of each pose, what cell that is (m, 3), and the hash table that finds it."""
    slots = 64
    while slots < 2 * len(poses):
        slots *= 2
    table = np.full(slots, -1, dtype=np.int32)
    cells = np.empty((len(poses), 3), dtype=np.int64)
    cell_of = np.empty(len(poses), dtype=np.int64)
    count = 0
    per_metre, per_radian = 1.0 / size_xy, turns / (2 * math.pi)
    for i in range(len(poses)):
        x = int64(math.floor(poses[i, 0] * per_metre))
        y = int64(math.floor(poses[i, 1] * per_metre))
        theta = int64(math.floor((poses[i, 2] + math.pi) * per_radian))
        if theta < 0 or theta >= turns:  # a division for each would be slow
            theta %= turns
        slot = _slot(x, y, theta, cells, table)
        if table[slot] < 0:
            table[slot] = count
            cells[count, 0], cells[count, 1], cells[count, 2] = x, y, theta
            count += 1
        cell_of[i] = table[slot]
    return cell_of, cells[:count], table


@njit(cache=True, nogil=True, forceinline=True)
def _slot(x: int, y: int, theta: int, cells: Index, table: NDArray[np.int32]) -> int:
    """Where a cell stands in the hash table, or the free place where it would."""
    mask = len(table) - 1
    slot = ((x * 73856093) ^ (y * 19349669) ^ (theta * 83492791)) & mask
    while True:
        target = table[slot]
        if target < 0 or (
            cells[target, 0] == x and cells[target, 1] == y and cells[target, 2] == theta
        ):
            return slot
        slot = (slot + 1) & mask


@njit(cache=True, nogil=True)
def _join_neighbours(cells: Index, table: NDArray[np.int32], turns: int) -> tuple[Index, int]:
    """Cluster (m,) of each cell, counted from 0, and their number.

    Each cell asks the half of its 26 neighbours that come after it (union-find).
    """
    parent = np.arange(len(cells))
    for cell in range(len(cells)):
        for step in range(14, 27):
            x = cells[cell, 0] + step // 9 - 1
            y = cells[cell, 1] + step // 3 % 3 - 1
            theta = (cells[cell, 2] + step % 3 - 1) % turns
            beside = table[_slot(x, y, theta, cells, table)]
            if beside >= 0:
                parent[_root(parent, beside)] = _root(parent, cell)
    clusters = np.full(len(cells), -1, dtype=np.int64)
    count = 0
    for cell in range(len(cells)):
        root = _root(parent, cell)
        if clusters[root] < 0:
            clusters[root] = count
            count += 1
        clusters[cell] = clusters[root]
    return clusters, count


@njit(cache=True, nogil=True)
def _root(parent: Index, cell: int) -> int:
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
    return cell
