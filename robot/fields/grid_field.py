"""Makes fields of maps of cells, as ROS has them."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.fields.cell_outline import cell_outline
from robot.fields.field import Field, FieldError
from robot.fields.floor_picture import Extent, FloorPicture, finest_resolution
from robot.fields.grid_map import load_map_yaml
from robot.fields.occupancy_grid import (
    OCCUPIED,
    UNKNOWN,
    MapError,
    OccupancyGrid,
    cell_distances,
)
from robot.geometry import Array, Pose2, heading_vectors

_TONES = np.concatenate([np.rint(np.linspace(254, 0, OCCUPIED + 1)), [205]]).astype(np.uint8)
"""Grey level by value, 0 to 100 and then -1, as map_server saves free, occupied and unknown."""


def load_ros_map(path: Path) -> Field:
    """Read the field of a map from map_server's YAML; it has the name of the file.

    Raises:
        FieldError: a file is missing or broken, no cell is occupied, or no cell is free.
    """
    try:
        return field_from_grid(load_map_yaml(path), path.stem)
    except MapError as error:
        raise FieldError(str(error)) from error


def field_from_grid(grid: OccupancyGrid, name: str) -> Field:
    """Return the field whose dark areas are the occupied cells (65 or more) of a map.

    Edges are where an occupied cell meets one that is not, or the end of the map. The start is the
    free cell farthest from all that is not free, heading along the map's own rows.

    Raises:
        FieldError: no cell is occupied, or no cell is free.
    """
    edges = cell_outline(grid.occupied) * grid.resolution
    if not len(edges):
        raise FieldError(f"the map {name} has no occupied cell to localize by")
    if not grid.free.any():
        raise FieldError(f"the map {name} has no free cell to drive on")
    return Field(
        name=name,
        floor=_floor(grid),
        edges=grid.origin.apply(edges.reshape(-1, 2)).reshape(-1, 4),
        tape=(),
        start=_roomiest(grid),
        grid=grid,
    )


def _roomiest(grid: OccupancyGrid) -> Pose2:
    clearance = cell_distances(np.pad(grid.free, 1))[1:-1, 1:-1]
    row, column = np.unravel_index(int(np.argmax(clearance)), clearance.shape)
    cell = Pose2((float(column) + 0.5) * grid.resolution, (float(row) + 0.5) * grid.resolution)
    return grid.origin @ cell


def _floor(grid: OccupancyGrid) -> FloorPicture:
    """Return the map as a picture along the map frame's axes; unknown around a turned map."""
    xmin, ymin, xmax, ymax = _extent(grid)
    resolution = finest_resolution(xmax - xmin, ymax - ymin)
    width = max(1, math.floor((xmax - xmin) / resolution + 1e-6))
    height = max(1, math.floor((ymax - ymin) / resolution + 1e-6))
    extent = (xmin, ymax - height * resolution, xmin + width * resolution, ymax)
    tones, cell = _shrunk(_TONES[grid.data.astype(np.int16)], grid.resolution, resolution)
    blank = FloorPicture(np.zeros((height, width), np.uint8), resolution, extent)
    image = cv2.warpAffine(
        tones,
        _cell_from_pixel(grid.origin, cell, blank.pixel_from_map),
        (width, height),
        flags=cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=int(_TONES[UNKNOWN]),
    )
    return FloorPicture(image.astype(np.uint8), resolution, extent)


def _extent(grid: OccupancyGrid) -> Extent:
    """Return the box around all cells, along the map frame's axes."""
    height, width = grid.data.shape
    corners = np.array([[0, 0], [width, 0], [0, height], [width, height]], dtype=np.float64)
    places = grid.origin.apply(corners * grid.resolution)
    (xmin, ymin), (xmax, ymax) = places.min(axis=0), places.max(axis=0)
    return float(xmin), float(ymin), float(xmax), float(ymax)


def _shrunk(tones: NDArray[np.uint8], cell: float, pixel: float) -> tuple[NDArray[np.uint8], Array]:
    """Return tones of cells that are no finer than the pixels, and the cells' sides (2,) [m].

    With finer cells, thin walls would fall between the pixels.
    """
    height, width = tones.shape
    size = [max(1, round(side * min(1.0, cell / pixel))) for side in (width, height)]
    if size == [width, height]:
        return tones, np.array([cell, cell])
    small = cv2.resize(tones, size, interpolation=cv2.INTER_AREA)
    return small.astype(np.uint8), cell * np.array([width, height]) / size


def _cell_from_pixel(origin: Pose2, cell: Array, pixel_from_map: Array) -> Array:
    """Return the transform (2, 3) from pixels of the floor picture to cells.

    Both have integer coordinates at their centres.
    """
    along_x, along_y = heading_vectors(np.array([origin.theta, origin.theta + math.pi / 2]))
    map_from_cell = np.column_stack([along_x * cell[0], along_y * cell[1], (origin.x, origin.y)])
    map_from_cell[:, 2] += map_from_cell[:, :2] @ (0.5, 0.5)
    pixel_from_cell = _homogeneous(pixel_from_map) @ _homogeneous(map_from_cell)
    return np.linalg.inv(pixel_from_cell)[:2].astype(np.float64)


def _homogeneous(affine: Array) -> Array:
    return np.vstack([affine, [0.0, 0.0, 1.0]])
