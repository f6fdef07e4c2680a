"""Exact share of each cell of a grid that an area covers, for any size of the cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array


def coverage(edges: Array, shape: tuple[int, int]) -> Array:
    """Return the covered share (h, w), 0 to 1, of each cell of a grid.

    Edges (n, 4) in cells form closed outlines. The area is on their left where y points up, as in
    ``edges``. Cell (row, column) covers column to column + 1 and row to row + 1; rows count along
    +y. The area outside the grid is cut off.

    The method is Green's theorem by cells. Edges are cut at all grid lines, so each piece lies in
    one cell. There it covers its height times the width to its right. In all cells further right it
    covers its height. The signed sum over an outline is the area inside.
    """
    height, width = shape
    start, end = _cut_at_grid_lines(edges)
    middle = (start + end) / 2
    column, row = np.floor(middle).astype(np.int64).T
    inside = (row >= 0) & (row < height) & (column < width)
    rise = (start[:, 1] - end[:, 1])[inside]
    part = np.where(column < 0, 0.0, middle[:, 0] - column)[inside]
    cell = row[inside] * (width + 1) + np.maximum(column[inside], 0)
    size = height * (width + 1)
    change: Array = np.bincount(cell, rise * (1 - part), size).astype(np.float64)
    change += np.bincount(cell + 1, rise * part, size)
    covered = np.cumsum(change.reshape(height, width + 1), axis=1)[:, :width]
    return np.clip(covered, 0, 1, out=covered)


def _cut_at_grid_lines(edges: Array) -> tuple[Array, Array]:
    """Cut edges (n, 4) wherever they cross whole x or y; return start and end points (m, 2)."""
    start, step = edges[:, :2], edges[:, 2:] - edges[:, :2]
    count = len(edges)
    whole = np.arange(count)
    owners, fractions = [whole, whole], [np.zeros(count), np.ones(count)]
    for axis in (0, 1):
        owner, line = _lines_between(start[:, axis], start[:, axis] + step[:, axis])
        owners.append(owner)
        fractions.append((line - start[owner, axis]) / step[owner, axis])
    owner, fraction = np.concatenate(owners), np.concatenate(fractions)
    order = np.lexsort((fraction, owner))
    owner, fraction = owner[order], fraction[order]
    points = start[owner] + fraction[:, None] * step[owner]
    same = owner[1:] == owner[:-1]
    return points[:-1][same], points[1:][same]


def _lines_between(a: Array, b: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the whole numbers strictly between a (n,) and b (n,): pair indices, numbers (m,)."""
    first = np.floor(np.minimum(a, b)) + 1
    counts = np.maximum(np.ceil(np.maximum(a, b)) - first, 0).astype(np.intp)
    owner = np.repeat(np.arange(len(a)), counts)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first[owner] + rank
