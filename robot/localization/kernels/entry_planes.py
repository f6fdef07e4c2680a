"""The table of distances with one 32-bit word per cell, so that a look-up reads memory once.

Within a cell the distance to an edge is nearly a linear function of x and y; along a straight edge
it is exactly one. A word holds the distance at the cell's first corner and the slopes along x and
y.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array

DIRECTIONS = 8
"""How many tables a field has: each is for rays of about one direction."""
FARTHEST = 8190
"""The greatest distance as a whole number (14 bits with sign): a step is 18 um if it is 0.15 m."""
STEEPEST = 254
"""A slope of one as a whole number (9 bits with sign)."""
ROWS = 64
"""How many rows of a table are converted at a time, so that intermediate arrays fit the cache."""
VALUE_SHIFT, X_SHIFT = 18, 9
"""The lowest bits of the value and of the slope along x; the slope along y has bits 0 to 8."""


def planes(
    distances: NDArray[np.float32], resolution: float, max_distance: float
) -> NDArray[np.int32]:
    """Return the words (directions, h, w) of a table (directions, h, w) of distances [m].

    Cell (row, column) lies between the places (row, column) and (row + 1, column + 1). The last row
    and column have no such cell; their distance is the greatest. Each part of a word takes the
    parts below it for its fraction: they are subtracted before it is rounded, so that a look-up
    need not mask them out.
    """
    words = np.full(distances.shape, FARTHEST << VALUE_SHIFT, dtype=np.int32)
    last = distances.shape[1] - 1
    for start in range(0, last, ROWS):
        end = min(start + ROWS, last)
        some = distances[:, start : end + 1]
        words[:, start:end, :-1] = _words(some, resolution, max_distance)
    return words


def _words(
    distances: NDArray[np.float32], resolution: float, max_distance: float
) -> NDArray[np.int64]:
    """Return the words (directions, h - 1, w - 1) of the cells between h rows and w columns."""
    corners = np.stack(
        [distances[:, :-1, :-1], distances[:, :-1, 1:], distances[:, 1:, :-1], distances[:, 1:, 1:]]
    ).astype(np.float64)
    # A distance cannot change by more than the way between two places. Where corners differ by
    # more, its sign has jumped far from an edge, and a plane would pass through zero.
    jump = np.ptp(corners, axis=0) > 1.5 * resolution
    d00, d01, d10, d11 = np.where(jump, np.abs(corners), corners)
    along_y = _rounded((d10 + d11 - d00 - d01) / (2 * resolution) * STEEPEST, 0.0)
    low = along_y & 511
    along_x = _rounded((d01 + d11 - d00 - d10) / (2 * resolution) * STEEPEST, low / 512)
    low |= (along_x & 511) << X_SHIFT
    step = max_distance / FARTHEST
    half_cell = 0.5 * resolution / STEEPEST * (along_x + (along_y & 511) / 512 + along_y)
    corner = ((d00 + d01 + d10 + d11) / 4 - half_cell) / step
    value = np.rint(np.clip(corner, -FARTHEST, FARTHEST) - low / 2**VALUE_SHIFT).astype(np.int64)
    words: NDArray[np.int64] = (value << VALUE_SHIFT) | low
    return words


def _rounded(slopes: Array, fraction: float | Array) -> NDArray[np.int64]:
    return np.rint(np.clip(slopes, -STEEPEST, STEEPEST) - fraction).astype(np.int64)
