"""Loads fields by name or file: drawings, generated fields, and maps of cells."""

from __future__ import annotations

import math
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.fields.edges import cell_outline
from robot.fields.field import Field, FieldError
from robot.fields.floor_picture import Extent, FloorPicture, finest_resolution
from robot.fields.generator.names import generated_seed
from robot.fields.grid_map import OCCUPIED, UNKNOWN, MapError, OccupancyGrid, load_map_yaml
from robot.fields.svg_field import field_of_drawing, load_svg
from robot.geometry import Array, Pose2, heading_vectors

GENERATED = "generated-0 to generated-4294967295, or an .svg or .yaml file"
_TONES = np.concatenate([np.rint(np.linspace(254, 0, OCCUPIED + 1)), [205]]).astype(np.uint8)
"""Grey level by value, 0 to 100 and then -1, as map_server saves free, occupied and unknown."""


def load_field(name: str, maps: Path) -> Field:
    """Load a field by the name of a drawing in the folder ``maps``, or from an SVG or YAML file.

    A bare name (``square``) is a drawing of the folder; a name with an ending or a folder is a
    file. ``generated-17`` is the field that is generated from the seed 17, for any ``maps``. A ROS
    map's field has the name of its YAML file.

    Raises:
        FieldError: there is no such field (the message lists the available names), or its file
            cannot be used.
    """
    seed = generated_seed(name)
    if seed is not None:
        from robot.fields.generator.generated import drawing  # noqa: PLC0415 - few fields are

        return _usable(field_of_drawing(drawing(seed), name))
    path = Path(name)
    if name and path.name == name and not path.suffix:
        path = maps / f"{name}.svg"
        if not path.is_file():
            available = ", ".join(field_names(maps)) or f"none in {maps}"
            raise FieldError(f"there is no field {name!r}; valid are {available}, {GENERATED}")
    if path.suffix.lower() == ".svg":
        return _usable(load_svg(path))
    if path.suffix.lower() in (".yaml", ".yml"):
        return _load_ros_map(path)
    available = ", ".join(field_names(maps))
    raise FieldError(f"{name!r} is no field; valid are {available}, {GENERATED}")


def field_names(maps: Path) -> list[str]:
    """Return the names of the drawings in a folder, sorted."""
    return sorted(path.stem for path in maps.glob("*.svg"))


def _usable(field: Field) -> Field:
    field.require_free()
    return field


def _load_ros_map(path: Path) -> Field:
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
    free = np.pad(grid.free, 1).astype(np.uint8)
    clearance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
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
