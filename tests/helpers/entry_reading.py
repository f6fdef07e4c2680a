"""The distances in a table of entry planes, read in plain NumPy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.kernels.entry_planes import FARTHEST, STEEPEST, VALUE_SHIFT


def distance_at(
    words: NDArray[np.int32], resolution: float, max_distance: float, position: tuple[Array, ...]
) -> Array:
    """Return signed distances [m] at places (direction, row, column).

    Rows and columns have fractions. It does in plain NumPy what the compiled look-ups do.
    """
    direction, row, column = position
    r, c = np.floor(row).astype(int), np.floor(column).astype(int)
    word = words[direction.astype(int), r, c].astype(np.int64)
    value, along_x, along_y = word / 2**VALUE_SHIFT, _low(word, 18) / 2**9, _low(word, 9)
    slope = along_x * (column - c) + along_y * (row - r)
    result: Array = value * max_distance / FARTHEST + slope * resolution / STEEPEST
    return result


def _low(word: NDArray[np.int64], bits: int) -> NDArray[np.int64]:
    """Return the lowest bits of a word as a signed number."""
    part = word & ((1 << bits) - 1)
    return np.where(part >> (bits - 1), part - (1 << bits), part)
