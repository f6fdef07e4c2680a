"""Occupancy grids: cells that are free, occupied or unknown."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2

UNKNOWN, FREE, OCCUPIED = -1, 0, 100
MAX_CELLS = 64_000_000
RESOLUTION_M = (1e-4, 100.0)
"""Smallest and largest cell [m]."""
FAR_M = 1e6
"""An origin farther away is a mistake [m]."""
FAR_CELLS = 1000
"""Distances between cells are counted up to this many: squares are exact."""

Cells = NDArray[np.int8]


class MapError(BrickPoseError, ValueError):
    """A map that cannot be used; the message says what is valid."""


@dataclass(frozen=True, eq=False)
class OccupancyGrid:
    """Cells that are free, occupied or unknown, as in nav_msgs/OccupancyGrid."""

    data: Cells = field(repr=False)
    """(h, w), read-only: -1 unknown, else 0 (free) to 100 (occupied). Row 0 is at the bottom."""
    resolution: float
    """Side of a cell [m]."""
    origin: Pose2
    """The outer corner of cell (0, 0) in the map frame; rows and columns turn with its heading."""

    def __post_init__(self) -> None:
        if self.data.ndim != 2 or not self.data.size or self.data.size > MAX_CELLS:
            raise MapError(f"a grid of shape {self.data.shape}; valid are 1 to {MAX_CELLS} cells")
        if self.data.dtype != np.int8 or self.data.min() < UNKNOWN or self.data.max() > OCCUPIED:
            raise MapError("a cell is out of range; valid are -1 (unknown) and 0 to 100")
        low, high = RESOLUTION_M
        if not low <= self.resolution <= high:
            raise MapError(f"resolution is {self.resolution} m; valid is {low:g} to {high:g} m")
        if not (self.origin.is_finite() and math.hypot(self.origin.x, self.origin.y) <= FAR_M):
            raise MapError(f"origin is {self.origin}; valid is within {FAR_M:g} m")
        self.data.setflags(write=False)

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """Which cells (h, w) are occupied: 65 or more, map_server's own threshold."""
        return self.data >= 65

    @property
    def free(self) -> NDArray[np.bool_]:
        """Which cells (h, w) are known to be free: 0 to 25, map_server's own threshold."""
        return (self.data >= FREE) & (self.data <= 25)

    def values_at(self, points: Array) -> Cells:
        """Return the values (n,) of the cells at points (n, 2) [m] of the map; -1 off the grid."""
        column, row = np.floor(self.origin.inverse().apply(points) / self.resolution).T
        height, width = self.data.shape
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        values = np.full(len(points), UNKNOWN, dtype=np.int8)
        values[inside] = self.data[row[inside].astype(np.intp), column[inside].astype(np.intp)]
        return values


def cell_distances(asked: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return how far cells (h, w) that are asked of are from the nearest other one [cells]."""
    cells = cv2.distanceTransform(asked.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    # Last digits depend on how many threads OpenCV may use; the squares are whole numbers.
    return np.sqrt(np.rint(np.square(np.minimum(cells, np.float32(FAR_CELLS)))))
