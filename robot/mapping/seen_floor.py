"""The floor that rays ran over, and the cells of a map: tape, floor that was seen, and unknown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from robot.fields.edges import outline
from robot.fields.floor_picture import coverage
from robot.fields.occupancy_grid import MAX_CELLS, OCCUPIED, UNKNOWN, OccupancyGrid
from robot.fields.unseen_floor import SIDE, cell_side, fill
from robot.geometry import Array, Pose2
from robot.mapping.ends import RaysOnFloor

MARGIN = 0.05
"""Unknown floor around all that was seen [m]."""
ROUGH = 0.7
"""How far an outline may run beside its cells' middles, in cells. Half and twice: a robot in a map
of *tee* that has gaps is as well localized."""

GOES_ON = 0.12
"""Where tape was seen that could not be drawn, it may go on this far [m]. Half: in a map of
*square* without a corner (seed 9103, 6 s; a drive of seed 9601 that begins known) a robot is
certain in 32 instead of 82 % of the pictures, and 385 instead of 2 mm off (rms); twice: in 78 %."""


@dataclass(frozen=True, eq=False)
class SeenFloor:
    """Where the camera has looked: along each ray until it first met an edge of anything."""

    polygons: tuple[Array, ...] = field(repr=False)
    """Each (n, 2) in the map, of one picture [m]: where its rays begin, and back where they end."""

    @classmethod
    def of(cls, rays: RaysOnFloor) -> SeenFloor:
        """Return the floor that was seen along rays."""
        ends = np.where(np.isfinite(rays.first), rays.first, rays.end)
        starts = np.flatnonzero(np.diff(rays.picture)) + 1
        pictures = zip(np.split(rays.begin, starts), np.split(ends, starts), strict=True)
        polygons = (np.vstack([begin, end[::-1]]) for begin, end in pictures)
        return cls(tuple(corners[np.isfinite(corners).all(axis=1)] for corners in polygons))

    def cells(self, origin: Pose2, side: float, shape: tuple[int, int]) -> NDArray[np.bool_]:
        """Return which cells (h, w) of a side [m] were seen; row 0 is at the bottom."""
        seen = np.zeros(shape, np.uint8)
        for polygon in self.polygons:
            if len(polygon):
                fill(seen, [origin.inverse().apply(polygon) / side])
        return seen > 0

    def outlines(self, open_ends: Array) -> tuple[Array, ...]:
        """Return the outlines (n, 2) of all seen floor [m]; one within another is of a hole.

        Around ``open_ends`` (n, 2) [m], tape may go on that is not drawn.
        """
        points = np.vstack(self.polygons)
        low, size = points.min(axis=0) - 2 * SIDE, np.ptp(points, axis=0) + 4 * SIDE
        side = cell_side(size)
        columns, rows = np.ceil(size / side).astype(int).tolist()
        cells = self.cells(Pose2(*low.tolist()), side, (rows, columns)).astype(np.uint8)
        # Rays end at tape, and leave it open.
        closed = cv2.morphologyEx(cells, cv2.MORPH_CLOSE, np.ones((5, 5), np.uint8))
        for x, y in np.floor((open_ends - low) / side).astype(int).tolist():
            cv2.circle(closed, (x, y), math.ceil(GOES_ON / side), 0, cv2.FILLED)
        contours, _ = cv2.findContours(closed, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        simple = [cv2.approxPolyDP(contour, ROUGH, True)[:, 0] for contour in contours]
        return tuple(low + (each + 0.5) * side for each in simple if len(each) > 2)


def occupancy(lines: Sequence[Array], width: float, seen: SeenFloor, side: float) -> OccupancyGrid:
    """Return the map of tape and of the floor that was seen, in cells of a side [m].

    A cell is 100 where tape covers at least half of it, 0 where bare floor was seen, and else -1.
    The grid's corner is at whole cells from the map's origin, so that cells stay where they are
    while the map grows. Beyond the most cells that a grid may have, they are larger.

    Args:
        lines: centre lines of tape, each (m, 2) in the map [m].
        width: of the tape [m].
        seen: where the camera has looked.
        side: of a cell [m].
    """
    points = np.vstack([*lines, *seen.polygons])
    low, high = points.min(axis=0) - MARGIN - width, points.max(axis=0) + MARGIN + width
    side = max(side, 1.01 * math.sqrt(float(np.prod(high - low)) / MAX_CELLS))
    corner = np.floor(low / side)
    columns, rows = (np.ceil(high / side) - corner).astype(int).tolist()
    origin = Pose2(*(side * corner).tolist())
    tape = outline(
        shapely.union_all(
            [
                shapely.buffer(
                    shapely.LineString(line), width / 2, cap_style="flat", join_style="mitre"
                )
                for line in lines
            ]
        )
    )
    covered = coverage(tape / side - np.tile(corner, 2), (rows, columns))
    cells = np.where(seen.cells(origin, side, (rows, columns)), 0, UNKNOWN).astype(np.int8)
    cells[covered > 0.5 - 1e-6] = OCCUPIED
    return OccupancyGrid(cells, side, origin)


def with_unseen(grid: OccupancyGrid, seen: SeenFloor) -> OccupancyGrid:
    """Return a map in which free cells that nobody looked at are unknown."""
    looked: NDArray[Any] = seen.cells(grid.origin, grid.resolution, grid.data.shape)
    cells = np.where((grid.data == 0) & ~looked, UNKNOWN, grid.data).astype(np.int8)
    return OccupancyGrid(cells, grid.resolution, grid.origin)
