"""A likelihood field of scans at several resolutions, to search a pose in (Olson 2009)."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array

CELL = 0.05
"""Side of a cell [m]."""
SD = 0.08
"""Distance from a surface at which a point fits half as well, about [m, standard deviation]."""
MARGIN = 0.4
"""Of the field around its surfaces [m]."""
BITS = 4
"""Lines are drawn with this many binary places of a cell."""
Levels = NDArray[np.float32]


class LikelihoodPyramid:
    """How well a point fits at each place, 0 to 1, and the best of that in squares of cells.

    Level h tells of each cell the best of the square of 2^h by 2^h cells that begins there.
    """

    def __init__(self, lines: Iterable[Array], levels: int) -> None:
        """Draw surfaces (m, 4) [m], all in one frame.

        Args:
            lines: pieces of surface, of at least one scan that is not empty.
            levels: number of resolutions.
        """
        drawn = np.vstack([*lines])
        ends = drawn.reshape(-1, 2)
        margin = MARGIN + CELL * 2 ** (levels - 1)
        self.corner: Array = ends.min(axis=0) - margin
        """(2,) of the first cell [m]."""
        width, height = np.ceil((ends.max(axis=0) + MARGIN - self.corner) / CELL).astype(int)
        free = np.full((height, width), 255, np.uint8)
        # OpenCV's pixels have their middles at whole numbers.
        cells = (drawn.reshape(-1, 2, 2) - self.corner) / CELL - 0.5
        pixels = np.rint(cells * 2**BITS).astype(np.int32)
        cv2.polylines(free, pixels, isClosed=False, color=0, shift=BITS)
        distance = CELL * cv2.distanceTransform(free, cv2.DIST_L2, 5)
        self.levels: Levels = np.zeros((levels, height, width), np.float32)
        """(levels, h, w)"""
        self.levels[0] = np.exp(-0.5 * np.square(distance / SD))
        for level in range(1, levels):
            _best_of_four(self.levels[level - 1], self.levels[level], 2 ** (level - 1))


def _best_of_four(finer: Levels, coarser: Levels, apart: int) -> None:
    """Write the best of four squares: at a cell, ``apart`` cells above, right, and both."""
    wide = finer.copy()
    np.maximum(wide[:, :-apart], finer[:, apart:], out=wide[:, :-apart])
    coarser[:] = wide
    np.maximum(coarser[:-apart], wide[apart:], out=coarser[:-apart])
