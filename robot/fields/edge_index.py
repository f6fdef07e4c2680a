"""Spatial index of edges: a ray is compared only with the edges along its path."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.fields.edges import bends
from robot.geometry import Array

FEW = 24
"""Up to this many edges, testing all of them is faster than walking through cells."""
MARGIN = 1e-6
"""Edges this near to a cell (in cells) count as touching it, so that rounding loses none."""


class EdgeIndex(NamedTuple):
    """Edges and the cells of a regular grid that they touch; compiled functions use it directly."""

    edges: Array
    """(n, 4) x0, y0, x1, y1 [m] with the dark side on the left."""
    bends: Array
    """(n, 2) angle from each edge to the outline's tangent at the edge's start and end [rad]."""
    starts: NDArray[np.int64]
    """(rows * columns + 1,): cell c is touched by ``items[starts[c]:starts[c + 1]]``."""
    items: NDArray[np.int64]
    """Indices of edges, cell by cell; row 0 is at the bottom."""
    x: float
    """Left border of the grid [m]; no edge touches a border."""
    y: float
    """Bottom border of the grid [m]."""
    cell: float
    """Side of a cell [m]."""
    columns: int
    rows: int


def index_edges(edges: Array, cell: float | None = None) -> EdgeIndex:
    """Build the index of edges (n, 4) [m], with cells of a side [m].

    With smaller cells, a ray tests fewer edges in each but walks through more cells. Both cost
    about the same with one to two edges in each cell; the default side aims at that.

    Raises:
        ValueError: the edges have another shape, or the side is not a positive number.
    """
    if edges.ndim != 2 or edges.shape[1] != 4:
        raise ValueError(f"edges have the shape {edges.shape}; valid is (n, 4)")
    if cell is not None and not 0 < cell < math.inf:
        raise ValueError(f"the cell is {cell} m; valid is more than 0")
    edges = np.array(edges, dtype=np.float64)
    points = edges.reshape(-1, 2) if len(edges) else np.zeros((1, 2))
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    side = _side(size, len(edges)) if cell is None else cell
    # The border lies a little outside, so that rounding makes no ray miss an edge on it.
    low = low - side / 64
    columns, rows = np.maximum(np.ceil((size + side / 32) / side), 1).astype(int)
    item, cell_number = _touched((edges - np.tile(low, 2)) / side, columns, rows)
    order = np.lexsort((item, cell_number))
    starts = np.searchsorted(cell_number[order], np.arange(columns * rows + 1)).astype(np.int64)
    items = item[order].astype(np.int64)
    turned = bends(edges)
    for array in (edges, turned, starts, items):
        array.setflags(write=False)
    return EdgeIndex(
        edges,
        turned,
        starts,
        items,
        float(low[0]),
        float(low[1]),
        float(side),
        int(columns),
        int(rows),
    )


def _side(size: Array, count: int) -> float:
    """Return the side of a cell [m] for ``count`` edges on an area of ``size`` (2,) [m]."""
    longest = float(size.max())
    if count <= FEW or longest == 0:
        return 2 * longest or 1.0
    # Edges that all lie along one line have no area; one cell for each edge is enough there.
    return max(1.5 * math.sqrt(float(np.prod(size)) / count), longest / count)


def _touched(edges: Array, columns: int, rows: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return pairs of an edge and a cell that it touches; the edges (n, 4) are given in cells."""
    left, right = np.minimum(edges[:, 0], edges[:, 2]), np.maximum(edges[:, 0], edges[:, 2])
    edge, column = _ranges(_clipped(left - MARGIN, columns), _clipped(right + MARGIN, columns))
    x0, y0, x1, y1 = edges[edge].T
    # The first and last y of each edge within each column; an upright edge lies there completely.
    width = x1 - x0
    slope = np.divide(y1 - y0, width, out=np.zeros_like(width), where=np.abs(width) > MARGIN)
    begin = y0 + slope * (np.clip(column - MARGIN, left[edge], right[edge]) - x0)
    end = y0 + slope * (np.clip(column + 1 + MARGIN, left[edge], right[edge]) - x0)
    upright = np.abs(width) <= MARGIN
    begin, end = np.where(upright, y0, begin), np.where(upright, y1, end)
    pair, row = _ranges(
        _clipped(np.minimum(begin, end) - MARGIN, rows),
        _clipped(np.maximum(begin, end) + MARGIN, rows),
    )
    return edge[pair], row * columns + column[pair]


def _clipped(values: Array, count: int) -> NDArray[np.intp]:
    return np.clip(np.floor(values), 0, count - 1).astype(np.intp)


def _ranges(
    first: NDArray[np.intp], last: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return all whole numbers from each first to its last: the pairs' indices, and the numbers."""
    counts = last - first + 1
    owner = np.repeat(np.arange(len(first)), counts)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first[owner] + rank
