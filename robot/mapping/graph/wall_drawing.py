"""Draws an occupancy grid from scans whose poses are known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.fields.occupancy_grid import UNKNOWN, OccupancyGrid
from robot.geometry import Array, Pose2
from robot.mapping.grid.beams import Beams
from robot.mapping.grid.cells import Grids, updated_occupancy_grid

MARGIN = 2
"""Cells around all that was seen."""


@dataclass(frozen=True, eq=False)
class WallDrawing:
    """Log odds of cells, and where beams ended in them."""

    odds: Grids
    """(h, w)"""
    sums: Grids
    """(h, w, 6) as ``updated_occupancy_grid`` has them."""
    corner: Array
    """(2,) of the first cell [m]."""
    cell: float
    """[m]"""

    @classmethod
    def of(cls, path: Array, scans: list[Beams], cell: float) -> WallDrawing:
        """Draw what scans show from the poses (t, 3) where they were taken."""
        seen = [
            Pose2.from_array(pose).apply(np.vstack([beams.begin, beams.end, np.zeros((1, 2))]))
            for pose, beams in zip(path, scans, strict=True)
        ]
        points = np.vstack(seen)
        corner = cell * (np.floor(points.min(axis=0) / cell) - MARGIN)
        width, height = (np.ceil((points.max(axis=0) - corner) / cell) + MARGIN).astype(int)
        odds = np.zeros((height, width), np.float32)
        sums = np.zeros((height, width, 6), np.float32)
        for pose, beams in zip(path, scans, strict=True):
            parts = beams.begin, beams.end, beams.beyond, beams.hit
            updated_occupancy_grid(odds, sums, corner, cell, np.ascontiguousarray(pose), *parts)
        return cls(odds, sums, corner, cell)

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""
        chance = np.rint(100 / (1 + np.exp(-self.odds)))
        cells = np.where(self.odds == 0, UNKNOWN, chance).astype(np.int8)
        return OccupancyGrid(cells, self.cell, Pose2(*self.corner.tolist()))

    @property
    def ends(self) -> Array:
        """(n, 2) where beams ended on average in each occupied cell [m]."""
        rows, columns = np.nonzero((self.sums[..., 0] > 0) & (self.odds > 0))
        inside = self.sums[rows, columns, 1:3] / self.sums[rows, columns, :1]
        corners = np.column_stack([columns, rows]) * self.cell
        return np.asarray(self.corner + corners + inside, np.float64)
