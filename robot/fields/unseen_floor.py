"""The floor of a map that nobody has looked at: there may be tape on it, or none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array

SEEN = "data-seen"
"""Attribute of a drawing's ``<svg>``: outlines of the floor that was looked at, in mm, y up; x and
y by turns, outlines divided by semicolons. Without it, all of the floor is known."""
SIDE = 0.02
"""Side of a cell [m]: rays that end at tape leave a cell of its edge open at most."""
REACH = 2
"""Cells around the seen floor that count as seen: gaps between rays, and edges of tape."""
MOST_ACROSS = 2000
"""Cells along the longer side of a map; of larger maps, cells are larger."""
FRACTION_BITS = 4
"""Corners of polygons are rounded to a sixteenth of a cell."""


class UnseenFloor(NamedTuple):
    """Cells that were seen; compiled functions ask how far a ray runs over them."""

    seen: NDArray[np.uint8]
    """(h, w) 1 if seen, row 0 at the bottom; without any cell, the whole floor is known."""
    left: float
    """Of the cells' lower left corner in the map [m]."""
    bottom: float
    side: float
    """Of a cell [m]."""

    @classmethod
    def beyond(cls, polygons: Sequence[Array]) -> UnseenFloor:
        """Return the floor beyond polygons (n, 2) in the map [m]; nothing if there is no polygon.

        A polygon within another one is a hole in it.
        """
        if not polygons:
            return cls(np.zeros((0, 0), np.uint8), 0.0, 0.0, SIDE)
        points = np.vstack(list(polygons))
        size = np.ptp(points, axis=0)
        side = cell_side(size)
        left, bottom = (points.min(axis=0) - REACH * side).tolist()
        columns, rows = (np.ceil(size / side).astype(int) + 2 * REACH).tolist()
        seen = np.zeros((rows, columns), np.uint8)
        fill(seen, [(each - (left, bottom)) / side for each in polygons])
        grown = cv2.dilate(seen, np.ones((2 * REACH + 1, 2 * REACH + 1), np.uint8))
        return cls(np.ascontiguousarray(grown, np.uint8), left, bottom, side)


def cell_side(size: Array) -> float:
    """Return the side of cells for a floor of a size (2,) [m]."""
    return max(SIDE, float(size.max()) / MOST_ACROSS)


def fill(cells: NDArray[np.uint8], polygons: Sequence[Array]) -> None:
    """Set cells (h, w) within polygons (n, 2); what lies in two of them is a hole.

    Corners are in cells, from the lower left corner of the first one.
    """
    # OpenCV counts from the middle of the first cell.
    corners = [np.rint((each - 0.5) * (1 << FRACTION_BITS)).astype(np.int32) for each in polygons]
    cv2.fillPoly(cells, corners, 1, shift=FRACTION_BITS)


@compiled()
def seen_until(x: float, y: float, dx: float, dy: float, reach: float, floor: UnseenFloor) -> float:
    """Return how far a ray runs over seen floor [m]; infinite as far as ``reach`` if all is seen.

    Args:
        x: of its start in the map [m].
        y: of its start.
        dx: of its direction, a unit vector.
        dy: of its direction.
        reach: how far it is followed [m].
        floor: the floor.
    """
    if floor.seen.size == 0:
        return math.inf
    for step in range(math.ceil(reach / floor.side) + 1):
        far = min(step * floor.side, reach)
        if not is_seen(x + far * dx, y + far * dy, floor):
            return far
    return math.inf


@compiled(inline="always")
def is_seen(x: float, y: float, floor: UnseenFloor) -> bool:
    """Return whether a point of the map [m] was looked at, if not all of the floor was."""
    column = math.floor((x - floor.left) / floor.side)
    row = math.floor((y - floor.bottom) / floor.side)
    rows, columns = floor.seen.shape
    within = 0 <= row < rows and 0 <= column < columns
    return within and bool(floor.seen[row, column])
