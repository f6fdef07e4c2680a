"""Joins particles into clusters by their cells, and computes the moments of each cluster.

The moments are summed within each cell about its first particle, and joined afterwards. Within a
cell, angles need no wrapping, and squares of small offsets lose no digits.
"""

from __future__ import annotations

import math

import numpy as np
from numba import int64
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array
from robot.localization.kernels.steps import wrapped

Index = NDArray[np.int64]

NO_WEIGHT = 1e-100
"""Clusters with less weight are not described: squares of such small numbers are zero."""
MASS, SQUARES = 0, 1
"""Columns: sum of weights, and of their squares."""
FIRST, SECOND, ORIGIN = 2, 5, 11
"""Columns of the sums of offsets (3), of their products (6) and of what they are from (3)."""
COLUMNS = 14
"""All columns of a cell: ORIGIN, with its three, is the last."""


@compiled()
def clustered(
    poses: Array, weights: Array, size_xy: float, turns: int, most: int
) -> tuple[Index, Index, Array, Array, Array]:
    """Join particles (n, 3) with weights (n,) into clusters.

    Args:
        poses: [m, m, rad] in the map.
        weights: weights of the particles; they sum to one.
        size_xy: side of a cell [m].
        turns: cells in a full turn.
        most: most clusters that are described.

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


@compiled()
def _sort_into_cells(
    poses: Array, size_xy: float, turns: int
) -> tuple[Index, Index, NDArray[np.int32]]:
    """Return the cell (n,) of each pose, the cells (m, 3), and the hash table that finds them."""
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


@compiled(forceinline=True)
def _slot(x: int, y: int, theta: int, cells: Index, table: NDArray[np.int32]) -> int:
    """Return the slot of a cell in the hash table, or the free slot where it belongs."""
    mask = len(table) - 1
    slot = ((x * 73856093) ^ (y * 19349669) ^ (theta * 83492791)) & mask
    while True:
        target = table[slot]
        if target < 0 or (
            cells[target, 0] == x and cells[target, 1] == y and cells[target, 2] == theta
        ):
            return slot
        slot = (slot + 1) & mask


@compiled()
def _join_neighbours(cells: Index, table: NDArray[np.int32], turns: int) -> tuple[Index, int]:
    """Return the cluster (m,) of each cell, counted from 0, and the number of clusters.

    Each cell is joined with the half of its 26 neighbours that come after it (union-find).
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


@compiled()
def _root(parent: Index, cell: int) -> int:
    while parent[cell] != cell:
        parent[cell] = parent[parent[cell]]
        cell = parent[cell]
    return cell


@compiled(fastmath={"contract"}, error_model="numpy")
def add_moments(poses: Array, weights: Array, cell_of: NDArray[np.int64], cells: int) -> Array:
    """Return the moments (m, COLUMNS) of the particles (n, 3) in each cell."""
    moments = np.zeros((cells, COLUMNS))
    seen = 0
    for i in range(len(poses)):
        cell = cell_of[i]
        if cell == seen:  # cells are numbered as they come
            seen += 1
            for a in range(3):
                moments[cell, ORIGIN + a] = poses[i, a]
        w = weights[i]
        x = poses[i, 0] - moments[cell, ORIGIN]
        y = poses[i, 1] - moments[cell, ORIGIN + 1]
        theta = wrapped(poses[i, 2] - moments[cell, ORIGIN + 2])
        moments[cell, MASS] += w
        moments[cell, SQUARES] += w * w
        moments[cell, FIRST] += w * x
        moments[cell, FIRST + 1] += w * y
        moments[cell, FIRST + 2] += w * theta
        moments[cell, SECOND] += w * x * x
        moments[cell, SECOND + 1] += w * x * y
        moments[cell, SECOND + 2] += w * x * theta
        moments[cell, SECOND + 3] += w * y * y
        moments[cell, SECOND + 4] += w * y * theta
        moments[cell, SECOND + 5] += w * theta * theta
    return moments


@compiled()
def describe(moments: Array, cluster_of: NDArray[np.int64], clusters: int) -> tuple[Array, Array]:
    """Return means (k, 3) and covariances (k, 3, 3) of the first clusters, by cells (m,).

    The covariance is divided by 1 - sum w^2, because particles lie closer to their own mean than to
    the true one.
    """
    middle = _middles(moments, cluster_of, clusters)
    sums = np.zeros((clusters, COLUMNS))
    offset = np.empty(3)
    for cell in range(len(moments)):
        k = cluster_of[cell]
        if k >= clusters:
            continue
        for a in range(2):
            offset[a] = moments[cell, ORIGIN + a] - middle[k, a]
        offset[2] = wrapped(moments[cell, ORIGIN + 2] - middle[k, 2])
        _add_about(sums[k], moments[cell], offset)
    means, covariances = np.empty((clusters, 3)), np.empty((clusters, 3, 3))
    shift = np.empty(3)
    for k in range(clusters):
        mass = sums[k, MASS]
        for a in range(3):
            shift[a] = sums[k, FIRST + a] / mass
            means[k, a] = middle[k, a] + shift[a]
        means[k, 2] = wrapped(means[k, 2])
        independent = max(1 - sums[k, SQUARES] / mass**2, 0.5)
        column = SECOND
        for a in range(3):
            for b in range(a, 3):
                product = sums[k, column] / mass - shift[a] * shift[b]
                covariances[k, a, b] = covariances[k, b, a] = product / independent
                column += 1
    return means, covariances


@compiled()
def _middles(moments: Array, cluster_of: NDArray[np.int64], clusters: int) -> Array:
    """Return a pose (k, 3) inside each cluster to take offsets from; headings by unit vectors."""
    toward = np.zeros((clusters, 3))
    middle = np.zeros((clusters, 3))
    for cell in range(len(moments)):
        k, mass = cluster_of[cell], moments[cell, MASS]
        if k < clusters and mass > 0:
            theta = moments[cell, ORIGIN + 2] + moments[cell, FIRST + 2] / mass
            toward[k, 0] += mass * math.cos(theta)
            toward[k, 1] += mass * math.sin(theta)
            toward[k, 2] += mass
            for a in range(2):
                middle[k, a] += mass * moments[cell, ORIGIN + a]
    for k in range(clusters):
        for a in range(2):
            middle[k, a] /= toward[k, 2]
        middle[k, 2] = math.atan2(toward[k, 1], toward[k, 0])
    return middle


@compiled()
def _add_about(sums: Array, cell: Array, offset: Array) -> None:
    """Add a cell's moments to those about a pose from which its own are an offset (3,) away."""
    mass = cell[MASS]
    sums[MASS] += mass
    sums[SQUARES] += cell[SQUARES]
    column = SECOND
    for a in range(3):
        sums[FIRST + a] += cell[FIRST + a] + mass * offset[a]
        for b in range(a, 3):
            crossed = offset[a] * cell[FIRST + b] + offset[b] * cell[FIRST + a]
            sums[column] += cell[column] + crossed + mass * offset[a] * offset[b]
            column += 1
