"""The table of distances as planes: one word a cell, so that a look-up reads memory once.

Between the four corners of a cell the distance is all but a plane: exactly so along a straight
edge. A word holds its value at the cell's corner and its slopes along x and y.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array

DIRECTIONS = 8
"""Tables of a field, each for rays of about one direction."""
FARTHEST = 8190
"""The greatest distance, in steps of the value (14 bits with sign): 18 um at 0.15 m."""
STEEPEST = 254
"""A slope of one, in steps of a slope (9 bits with sign)."""
ROWS = 64
"""Of a table, are worked on at a time: what of a large one is in between would not fit caches."""
VALUE_SHIFT, X_SHIFT = 18, 9
"""Where value and slope along x stand in the word; the slope along y is its lowest part."""


def planes(
    distances: NDArray[np.float32], resolution: float, max_distance: float
) -> NDArray[np.int32]:
    """Words (directions, h, w) of a table (directions, h, w) of distances [m].

    Cell (row, column) lies between the places (row, column) and (row + 1, column + 1); the last
    row and column, which have no such cell, are as far as can be. A part of a word is chosen such
    that the parts below it, read as its fraction, only round it: who looks it up need not cut
    them off.
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
    """Words (directions, h - 1, w - 1) of the cells between h rows and w columns."""
    corners = np.stack(
        [distances[:, :-1, :-1], distances[:, :-1, 1:], distances[:, 1:, :-1], distances[:, 1:, 1:]]
    ).astype(np.float64)
    # A distance changes by no more than the way, so corners that differ by more are not at an edge:
    # there the sign ends, and a plane would pass through zero.
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


def distance_at(
    words: NDArray[np.int32], resolution: float, max_distance: float, position: tuple[Array, ...]
) -> Array:
    """Distances [m], with sign, at places (direction, row, column), the latter two with fractions.

    What the compiled look-ups do, in plain NumPy.
    """
    direction, row, column = position
    r, c = np.floor(row).astype(int), np.floor(column).astype(int)
    word = words[direction.astype(int), r, c].astype(np.int64)
    value, along_x, along_y = word / 2**VALUE_SHIFT, _low(word, 18) / 2**9, _low(word, 9)
    slope = along_x * (column - c) + along_y * (row - r)
    result: Array = value * max_distance / FARTHEST + slope * resolution / STEEPEST
    return result


def _low(word: NDArray[np.int64], bits: int) -> NDArray[np.int64]:
    """The lowest bits of a word, with sign."""
    part = word & ((1 << bits) - 1)
    return np.where(part >> (bits - 1), part - (1 << bits), part)
