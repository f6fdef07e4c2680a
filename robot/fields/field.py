"""The field: the floor that the robot drives on, and the robot's map of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from robot.errors import BrickPoseError
from robot.fields import edges as edge_geometry
from robot.fields.edge_index import EdgeIndex, index_edges
from robot.fields.edges import lengths, sample
from robot.fields.floor_picture import Extent, FloorPicture, coverage
from robot.fields.occupancy_grid import MAX_CELLS, OccupancyGrid
from robot.fields.ray_casting import cast_rays
from robot.fields.unseen_floor import UnseenFloor
from robot.fields.visibility import Visibility, visibility
from robot.geometry import Array, Pose2
from robot.scanning.tape import Tape

__all__ = ["Field", "FieldError", "FloorPicture"]

_LIGHT = 128
"""Grey level from which on floor counts as light."""

CONTRAST = 64
"""On a dark floor, what differs from it by this many grey levels is tape or clutter."""

_LEAST_FREE = 0.1
"""Tape encloses nothing if less than this share of its bounding box is free floor."""

_MAX_SEARCH_CELLS = 1_000_000
STEP, TOLERANCE = 0.010, 0.008
"""Edges are compared at points STEP apart, which may be off by TOLERANCE [m]: half of STEP and a
little more."""
FACING = 0.95
"""Smallest cosine between the normals of matching points, and smallest share of such points."""
FOLDS = (2, 3, 4, 5, 6, 8)
"""The full turn is divided by each of these numbers; all multiples of the parts are tried."""


class FieldError(BrickPoseError, ValueError):
    """A field that cannot be used, or a pose that is not on it; the message says what is valid."""

    exit_code = 2


@dataclass(frozen=True, eq=False)
class Field:
    """A floor with tape, dark or light (or the occupied cells of a ROS map), and its edges."""

    name: str
    floor: FloorPicture
    edges: Array = field(repr=False)
    """(n, 4) x0, y0, x1, y1 [m] in the map frame; the tape is to the left (``edges``)."""
    tape: tuple[Tape, ...]
    """The kinds of tape, that of the largest area first; () if the field is not of tape."""
    start: Pose2
    """Start pose of the robot in the map frame."""
    grid: OccupancyGrid | None = field(default=None, repr=False)
    """The ROS map that the field comes from; None if the field is of tape."""
    notes: Mapping[str, str] = field(default_factory=dict, repr=False)
    """Attributes ``data-...`` of its drawing, which a feature may read."""
    seen: tuple[Array, ...] = field(default=(), repr=False)
    """Outlines (n, 2) [m] of the floor that was looked at; () if all of the floor is known."""

    def __post_init__(self) -> None:
        if self.edges.ndim != 2 or self.edges.shape[1] != 4 or not len(self.edges):
            raise FieldError(f"edges have the shape {self.edges.shape}; valid is (1 or more, 4)")
        if not np.isfinite(self.edges).all():
            raise FieldError("edges are not finite")
        self.edges.setflags(write=False)
        self.require_inside(self.start)

    @property
    def tape_width(self) -> float | None:
        """Width of the first kind of tape [m]; None if the field is not of tape."""
        return self.tape[0].width if self.tape else None

    @property
    def normals(self) -> Array:
        """Unit vectors (n, 2) across the edges, away from the tape."""
        return edge_geometry.normals(self.edges)

    @cached_property
    def unseen(self) -> UnseenFloor:
        """The floor that nobody has looked at."""
        return UnseenFloor.beyond(self.seen)

    @cached_property
    def edge_index(self) -> EdgeIndex:
        """Spatial index of the edges, for casting rays."""
        return index_edges(self.edges)

    def ranges(self, poses: Array, bearings: Array, range_max: float) -> Array:
        """Return what a perfect laser would measure at poses, with tape for walls.

        Args:
            poses: of the laser in the map (n, 3) [m, m, rad].
            bearings: (k,) [rad], from +x of the laser, anticlockwise.
            range_max: how far it measures [m].

        Returns:
            (n, k) [m]; +inf where a ray meets no tape.
        """
        result = np.empty((len(poses), len(bearings)))
        cast_rays(poses, bearings, self.edge_index, range_max, result)
        return result

    @cached_property
    def sharp_ends(self) -> NDArray[np.bool_]:
        """(n, 2) whether the outline ends, or turns sharply, at each edge's start and end."""
        return edge_geometry.sharp_ends(self.edges)

    @cached_property
    def symmetries(self) -> tuple[Pose2, ...]:
        """Rotations that map the edges onto themselves, except the full turn; () for a ROS map."""
        return symmetries(self.edges) if self.grid is None else ()

    @cached_property
    def visibility(self) -> Visibility:
        """Which parts of the edges the line scanner sees with its default settings."""
        return visibility(self.edges, self.tape)

    @property
    def extent(self) -> Extent:
        """xmin, ymin, xmax, ymax [m] of the floor in the map frame."""
        return self.floor.extent

    def contains(self, pose: Pose2) -> bool:
        """Return whether a pose lies on the floor picture; its heading may be any finite number."""
        xmin, ymin, xmax, ymax = self.extent
        on_floor = xmin <= pose.x <= xmax and ymin <= pose.y <= ymax
        return on_floor and pose.is_finite()

    def require_inside(self, pose: Pose2) -> None:
        """Refuse a pose that is not on the field.

        Raises:
            FieldError: the pose is outside; the message names it and the limits of the field.
        """
        if not self.contains(pose):
            xmin, ymin, xmax, ymax = self.extent
            raise FieldError(
                f"({pose.x:z.3f}, {pose.y:z.3f}) m, {pose.theta:z.3f} rad is not on the field "
                f"{self.name}; valid is x {xmin:.3f} to {xmax:.3f}, y {ymin:.3f} to {ymax:.3f} m"
            )

    def require_free(self) -> None:
        """Refuse a field without room for a robot.

        Raises:
            FieldError: the field has no free floor.
        """
        _ = self._free_cells

    def occupancy(self, resolution: float) -> OccupancyGrid:
        """Return the whole floor as cells of a side [m]; row 0 is at the bottom.

        Of tape, a cell is 100 where tape covers at least half of it, else 0. Of a ROS map, a cell
        has the map's value at the cell's centre, and -1 beyond the map.

        Raises:
            FieldError: the resolution is not a positive number, or gives too many cells.
        """
        xmin, ymin, xmax, ymax = self.extent
        if not 0 < resolution < math.inf:
            raise FieldError(f"the resolution is {resolution} m; valid is more than 0")
        # Rounding must not add a cell to a floor of whole cells.
        width = max(1, math.ceil((xmax - xmin) / resolution - 1e-6))
        height = max(1, math.ceil((ymax - ymin) / resolution - 1e-6))
        if width * height > MAX_CELLS:
            raise FieldError(f"{width} x {height} cells are too many; valid are {MAX_CELLS}")
        if self.grid is None:
            in_cells = (self.edges - np.tile([xmin, ymin], 2)) / resolution
            # Rounding must not make tape ragged that ends in the middle of cells.
            cells = np.where(coverage(in_cells, (height, width)) > 0.5 - 1e-6, 100, 0)
        else:
            rows, columns = np.mgrid[:height, :width] + 0.5
            points = np.column_stack([columns.ravel(), rows.ravel()]) * resolution + (xmin, ymin)
            cells = self.grid.values_at(points).reshape(height, width)
        return OccupancyGrid(cells.astype(np.int8), resolution, Pose2(xmin, ymin))

    def free_poses(self, rng: np.random.Generator, count: int) -> Array:
        """Draw poses (count, 3) uniformly from the free floor, with any heading.

        The free floor is the light floor within ``drive_area``, or the free cells of a ROS map. On
        a field with light tape, it is the floor of about the most frequent brightness.
        """
        origin, side, width, cells = self._free_cells
        rows, columns = divmod(cells[rng.integers(0, len(cells), count)], width)
        chosen = np.column_stack([columns, rows]) + rng.random((count, 2))
        places = origin.apply(chosen * side)
        return np.column_stack([places, rng.uniform(-math.pi, math.pi, count)])

    @cached_property
    def drive_area(self) -> Extent:
        """The area where robots drive, as xmin, ymin, xmax, ymax [m]: the tape's bounding box.

        If the box holds almost nothing but tape, it is the whole floor: robots then drive beside a
        line.
        """
        box = self._tape_box
        if self.grid is None and self.light_cells(box).free.mean() < _LEAST_FREE:
            return self.extent
        return box

    def farthest_outside(self, points: Array) -> float:
        """Return how far points (n, 2) reach beyond the drive area [m]; 0 is not at all."""
        low, high = np.array(self.drive_area[:2]), np.array(self.drive_area[2:])
        return float(max((low - points).max(), (points - high).max(), 0.0))

    @cached_property
    def _tape_box(self) -> Extent:
        points = self.edges.reshape(-1, 2)
        (xmin, ymin), (xmax, ymax) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        return xmin, ymin, xmax, ymax

    @cached_property
    def _free_cells(self) -> tuple[Pose2, float, int, NDArray[np.int32]]:
        """The grid's origin, the side of a cell [m], cells in a row, and free cells (n,).

        A cell is its number, counted by rows: a floor has up to a million cells.
        """
        grid = self.grid or self.light_cells(self.drive_area)
        free = np.flatnonzero(grid.free).astype(np.int32)
        if not len(free):
            raise FieldError(f"the field {self.name} has no free floor")
        return grid.origin, grid.resolution, grid.free.shape[1], free

    def light_cells(self, box: Extent) -> OccupancyGrid:
        """Return the free floor within a box, in cells of a few millimetres."""
        low = np.array(box[:2])
        size = np.array(box[2:]) - low
        side = max(self.floor.resolution, math.sqrt(size[0] * size[1] / _MAX_SEARCH_CELLS))
        width, height = np.maximum(np.round(size / side), 1).astype(int)
        # Transform from pixels of the cells' picture, row 0 at its bottom, to the floor picture.
        pixel = self.floor.pixel_from_map
        step = pixel[:, :2] * side
        place = np.column_stack([step, pixel[:, :2] @ low + pixel[:, 2] + step.sum(axis=1) / 2])
        light = cv2.warpAffine(
            self.floor.image,
            place,
            (int(width), int(height)),
            flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        cells = np.where(self._free_floor(light), 0, 100).astype(np.int8)
        return OccupancyGrid(cells, side, Pose2(float(low[0]), float(low[1])))

    def _free_floor(self, levels: NDArray[Any]) -> NDArray[np.bool_]:
        """Return where grey levels (h, w) of the floor are of floor without tape or clutter."""
        if not any(kind.light for kind in self.tape):
            return np.asarray(levels >= _LIGHT)
        usual = int(np.bincount(self.floor.image.ravel()).argmax())
        return np.asarray(np.abs(levels.astype(np.int16) - usual) < CONTRAST)


def symmetries(edges: Array) -> tuple[Pose2, ...]:
    """Return every rotation, as a pose in the map, that maps edges (n, 4) onto themselves.

    The rotations are about the edges' centre. There are none if only a full turn does it.
    """
    points, normals = sample(edges, STEP)
    weights = lengths(edges)
    middles = (edges[:, :2] + edges[:, 2:]) / 2
    centre = (middles * weights[:, None]).sum(axis=0) / weights.sum()
    tree = cKDTree(points)
    turns = {round(2 * math.pi * part / fold, 9) for fold in FOLDS for part in range(1, fold)}
    kept = []
    for turn in sorted(turns):
        about = Pose2(*centre.tolist()) @ Pose2(theta=turn) @ Pose2(*(-centre).tolist())
        distances, nearest = tree.query(about.apply(points), distance_upper_bound=TOLERANCE)
        if np.isfinite(distances).all():
            turned = Pose2(theta=turn).apply(normals)
            if ((turned * normals[nearest]).sum(axis=1) > FACING).mean() > FACING:
                kept.append(about)
    return tuple(kept)
