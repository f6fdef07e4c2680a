"""The outline of the dark cells of a grid, as edges: ``cell_outline``."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array

_Points = tuple[NDArray[np.intp], NDArray[np.intp]]


def cell_outline(dark: NDArray[np.bool_]) -> Array:
    """Return the edges (n, 4), in cells, around the dark cells (h, w) of a grid.

    Cell (row, column) covers column to column + 1 in x and row to row + 1 in y. The area outside
    the grid counts as light. Edges of neighbouring cells are merged into runs.
    """
    padded = np.pad(dark, 1).astype(np.int8)
    # +1 where the cell after the line is dark and the one before is light; -1 for the reverse.
    line, start, end, sign = _runs(np.diff(padded, axis=0)[:, 1:-1])
    lying = _directed(sign > 0, (start, line), (end, line))
    line, start, end, sign = _runs(np.diff(padded, axis=1)[1:-1].T)
    standing = _directed(sign < 0, (line, start), (line, end))
    return np.vstack([lying, standing])


def _directed(forward: NDArray[np.bool_], low: _Points, high: _Points) -> Array:
    """Return edges (n, 4) from the low to the high end where forward, else from high to low."""
    edges = np.column_stack([*low, *high]).astype(np.float64)
    edges[~forward] = edges[~forward][:, [2, 3, 0, 1]]
    return edges


def _runs(steps: NDArray[np.int8]) -> tuple[NDArray[Any], ...]:
    """Return runs of equal non-zero values in the rows: row, first, last + 1, value, each (n,)."""
    padded = np.pad(steps, ((0, 0), (1, 1)))
    change = np.diff(padded, axis=1) != 0
    row, start = np.nonzero(change[:, :-1] & (steps != 0))
    _, end = np.nonzero(change[:, 1:] & (steps != 0))
    return row, start, end + 1, steps[row, start]
