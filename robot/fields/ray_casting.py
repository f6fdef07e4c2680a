"""Exact distances along rays to the edges of a field."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.fields.edge_index import EdgeIndex
from robot.geometry import Array

TINY = 1e-200
"""Replaces zero in a divisor."""


@compiled()
def cast_rays(
    poses: Array, bearings: Array, index: EdgeIndex, range_max: float, result: Array
) -> None:
    """Fill ``result`` (n, k) with the distances that a scan from poses (n, 3) would report."""
    for i in range(len(poses)):
        x, y, theta = poses[i]
        for j in range(len(bearings)):
            heading = theta + bearings[j]
            dx, dy = math.cos(heading), math.sin(heading)
            result[i, j], _ = cast_toward(x, y, dx, dy, index, range_max)


@compiled(error_model="numpy", forceinline=True)
def cast_toward(
    x: float, y: float, dx: float, dy: float, index: EdgeIndex, range_max: float
) -> tuple[float, int]:
    """Return the distance [m] to the first edge met from its light side, and the edge's number.

    If no edge is met within the range, the result is (+inf, -1). Of edges at the same distance, it
    is the one with the smallest number.

    Args:
        x: start of the ray [m].
        y: start of the ray [m].
        dx: direction of the ray, a unit vector.
        dy: direction of the ray, a unit vector.
        range_max: how far the ray reaches [m].
    """
    if index.columns * index.rows == 1:
        edges, items = index.edges, index.items
        nearest, met = _nearest_of(x, y, dx, dy, edges, items, 0, len(items), range_max, -1)
    else:
        nearest, met = _walk(x, y, dx, dy, index, range_max)
    return (nearest, met) if met >= 0 else (math.inf, -1)


@compiled(error_model="numpy", forceinline=True)
def tangent_at(x: float, y: float, edge: int, index: EdgeIndex) -> tuple[float, float]:
    """Return the outline's tangent at a point of an edge, about as long as the edge [m].

    On the chords of a curve the tangent turns evenly. With the directions of the chords alone, a
    motion along a curve would seem to change ranges.
    """
    edges, bends = index.edges, index.bends
    ex, ey = edges[edge, 2] - edges[edge, 0], edges[edge, 3] - edges[edge, 1]
    first, last = bends[edge, 0], bends[edge, 1]
    if first == 0.0 and last == 0.0:
        return ex, ey
    along = ((x - edges[edge, 0]) * ex + (y - edges[edge, 1]) * ey) / (ex * ex + ey * ey)
    turn = first + (last - first) * min(max(along, 0.0), 1.0)
    return ex - turn * ey, ey + turn * ex


@compiled(error_model="numpy", forceinline=True)
def _walk(
    x: float, y: float, dx: float, dy: float, index: EdgeIndex, range_max: float
) -> tuple[float, int]:
    """Search cell by cell (Amanatides and Woo, A Fast Voxel Traversal Algorithm, 1987).

    The search ends when the nearest edge met so far is no farther than the end of the ray's path
    through the cell.
    """
    nearest, met = range_max, -1
    cell, columns, rows = index.cell, index.columns, index.rows
    # The divisor is never zero: a cell border that is parallel to the ray is merely very far.
    per_x, per_y = 1.0 / (dx or TINY), 1.0 / (dy or TINY)
    left, bottom = index.x - x, index.y - y
    enter = _enter(left, bottom, per_x, per_y, columns * cell, rows * cell)
    if enter > range_max or enter == math.inf:
        return nearest, met
    column = int(min(max((enter * dx - left) / cell, 0.0), columns - 1.0))
    row = int(min(max((enter * dy - bottom) / cell, 0.0), rows - 1.0))
    next_x = (left + (column + (dx >= 0.0)) * cell) * per_x
    next_y = (bottom + (row + (dy >= 0.0)) * cell) * per_y
    while 0 <= column < columns and 0 <= row < rows:
        current = row * columns + column
        first, last = index.starts[current], index.starts[current + 1]
        nearest, met = _nearest_of(
            x, y, dx, dy, index.edges, index.items, first, last, nearest, met
        )
        if nearest <= min(next_x, next_y):
            break
        if next_x <= next_y:
            column += 1 if dx >= 0.0 else -1
            next_x += cell * abs(per_x)
        else:
            row += 1 if dy >= 0.0 else -1
            next_y += cell * abs(per_y)
    return nearest, met


@compiled(error_model="numpy", forceinline=True)
def _nearest_of(
    x: float,
    y: float,
    dx: float,
    dy: float,
    edges: Array,
    items: NDArray[np.int64],
    first: int,
    last: int,
    nearest: float,
    met: int,
) -> tuple[float, int]:
    """Return the nearest of the edge met so far and the edges ``items[first:last]``."""
    for k in range(first, last):
        number = items[k]
        x0, y0 = edges[number, 0] - x, edges[number, 1] - y
        x1, y1 = edges[number, 2] - x, edges[number, 3] - y
        # An edge is met if its ends lie on different sides of the ray. An end that two edges share
        # lies on the same side for both, whatever the rounding: no ray slips through between them.
        side0, side1 = x0 * dy - y0 * dx, x1 * dy - y1 * dx
        if not (side0 <= 0.0 <= side1 and side0 < side1):
            continue
        along0, along1 = x0 * dx + y0 * dy, x1 * dx + y1 * dy
        along = along0 + (along1 - along0) * (side0 / (side0 - side1))
        if 0.0 <= along < nearest or (along == nearest and (met < 0 or number < met)):
            nearest, met = along, number
    return nearest, met


@compiled(error_model="numpy", forceinline=True)
def _enter(
    left: float, bottom: float, per_x: float, per_y: float, width: float, height: float
) -> float:
    """Return how far along a ray the grid begins [m]: 0 from within, +inf if the ray misses it."""
    if -width <= left <= 0.0 and -height <= bottom <= 0.0:
        return 0.0
    if math.isnan(left + bottom + per_x + per_y):
        return math.inf
    to_left, to_right = left * per_x, (left + width) * per_x
    to_bottom, to_top = bottom * per_y, (bottom + height) * per_y
    enter = max(min(to_left, to_right), min(to_bottom, to_top), 0.0)
    leave = min(max(to_left, to_right), max(to_bottom, to_top))
    return enter if enter <= leave else math.inf
