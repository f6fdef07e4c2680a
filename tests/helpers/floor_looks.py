"""A look at one point of a floor, and along one ray."""

import math

import numpy as np

from robot.fields.edge_index import EdgeIndex
from robot.fields.floor_picture import FloorPicture
from robot.fields.ray_casting import cast_toward


def grey_at(floor: FloorPicture, points: np.ndarray) -> np.ndarray:
    """Grey levels (n,) of the pixels that contain points (n, 2) [m]; outside, of the border."""
    affine = floor.pixel_from_map
    column, row = np.floor(points @ affine[:, :2].T + affine[:, 2] + 0.5).T
    height, width = floor.image.shape
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    grey = np.full(len(points), floor.border, dtype=np.uint8)
    grey[inside] = floor.image[row[inside].astype(np.intp), column[inside].astype(np.intp)]
    return grey


def cast_ray(
    x: float, y: float, heading: float, index: EdgeIndex, range_max: float
) -> tuple[float, int]:
    return cast_toward(x, y, math.cos(heading), math.sin(heading), index, range_max)
