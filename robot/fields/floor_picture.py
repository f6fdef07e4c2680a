"""Picture of the floor from above: what a simulated camera looks at.

It has clean grey areas with anti-aliased edges; texture, light and noise are added where it is
seen.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from robot.fields.edges import outline
from robot.geometry import Array

FINEST_M = 0.001
"""Size of a pixel [m], unless the field is too large for it."""

MAX_PIXELS = 16_000_000

PAPER = 255
"""Grey level where nothing is drawn."""

Extent = tuple[float, float, float, float]
"""xmin, ymin, xmax, ymax [m] in the map frame."""


@dataclass(frozen=True, eq=False)
class FloorPicture:
    """The floor from above; its rows run along -y of the map: row 0 is at the top, at ymax.

    Pixel (row, column) shows the square from xmin + column * resolution to one resolution further
    right, and from ymax - row * resolution to one further down. Its **centre** therefore lies half
    a pixel inside that corner, and has integer coordinates (column, row) in OpenCV's convention.
    """

    image: NDArray[np.uint8] = field(repr=False)
    """(h, w) grey levels, read-only."""
    resolution: float
    """Side of a pixel [m]."""
    extent: Extent
    """The outer border of the picture [m]."""

    def __post_init__(self) -> None:
        height, width = self.image.shape
        xmin, ymin, xmax, ymax = self.extent
        shown = np.array([width, height]) * self.resolution
        if not np.allclose([xmax - xmin, ymax - ymin], shown, atol=1e-6 * self.resolution):
            raise ValueError(
                f"{width} x {height} px of {self.resolution} m do not cover the extent"
            )
        self.image.setflags(write=False)

    @property
    def pixel_from_map(self) -> Array:
        """(2, 3) affine transform from the map [m] to pixels (column, row), OpenCV's convention."""
        scale = 1 / self.resolution
        xmin, _, _, ymax = self.extent
        return np.array([[scale, 0, -xmin * scale - 0.5], [0, -scale, ymax * scale - 0.5]])

    def scaled(self, factor: float) -> FloorPicture:
        """Return the same picture for a floor enlarged by a factor about the map's origin."""
        if factor == 1:
            return self
        xmin, ymin, xmax, ymax = (factor * side for side in self.extent)
        return FloorPicture(self.image, factor * self.resolution, (xmin, ymin, xmax, ymax))

    @cached_property
    def border(self) -> int:
        """The most frequent grey level along the picture's border, to be shown outside it."""
        rim = [self.image[0], self.image[-1], self.image[:, 0], self.image[:, -1]]
        return int(np.bincount(np.concatenate(rim)).argmax())


@dataclass(frozen=True)
class Layer:
    """One coat of paint on the floor."""

    area: shapely.Geometry = field(repr=False)
    """Polygons in the map frame [m]."""
    grey: float
    """0 to 255."""
    alpha: float = 1.0
    """0 (invisible) to 1 (covers what is below)."""


def finest_resolution(width: float, height: float) -> float:
    """Return a pixel's side [m] for a floor's width and height [m]: 1 mm, more on large floors."""
    return max(FINEST_M, math.sqrt(width * height / MAX_PIXELS))


def paint(extent: Extent, layers: Sequence[Layer]) -> FloorPicture:
    """Paint layers onto paper, first to last; each pixel gets the mean over its area.

    Only whole pixels are kept, so the picture may end up to one pixel before the extent's right and
    lower border.
    """
    xmin, ymin, xmax, ymax = extent
    resolution = finest_resolution(xmax - xmin, ymax - ymin)
    # A border on a whole pixel must not lose that pixel to rounding: programs write two decimals.
    width = max(1, math.floor((xmax - xmin) / resolution + 0.01))
    height = max(1, math.floor((ymax - ymin) / resolution + 0.01))
    ymin = ymax - height * resolution
    image = np.full((height, width), PAPER, dtype=np.float32)
    for layer in _joined(layers):
        _coat(image, layer, (xmin, ymin), resolution)
    shown = (xmin, ymin, xmin + width * resolution, ymax)
    return FloorPicture(np.rint(image[::-1]).astype(np.uint8), resolution, shown)


def _joined(layers: Sequence[Layer]) -> list[Layer]:
    """Unite successive layers of the same paint: otherwise a seam would show where they touch."""
    joined: list[list[Layer]] = []
    for layer in layers:
        if joined and (layer.grey, layer.alpha) == (joined[-1][0].grey, joined[-1][0].alpha):
            joined[-1].append(layer)
        else:
            joined.append([layer])
    return [group[0] if len(group) == 1 else _united(group) for group in joined]


def _united(group: list[Layer]) -> Layer:
    area = shapely.union_all([layer.area for layer in group])
    return Layer(area, group[0].grey, group[0].alpha)


def _coat(
    image: NDArray[np.float32], layer: Layer, corner: tuple[float, float], resolution: float
) -> None:
    """Paint one layer onto an image (h, w) whose row 0 is at the bottom, from a corner [m]."""
    edges = (outline(layer.area) - np.tile(corner, 2)) / resolution
    if not len(edges):
        return
    height, width = image.shape
    left, bottom = np.floor(edges.reshape(-1, 2).min(axis=0)).astype(int)
    right, top = np.ceil(edges.reshape(-1, 2).max(axis=0)).astype(int)
    rows, columns = _within(bottom, top, height), _within(left, right, width)
    window = image[rows, columns]
    covered = coverage(edges - np.tile([columns.start, rows.start], 2), window.shape)
    window += (covered * layer.alpha * (layer.grey - window)).astype(np.float32)


def _within(first: int, last: int, size: int) -> slice:
    return slice(min(max(first, 0), size), min(max(last, 0), size))


def coverage(edges: Array, shape: tuple[int, int]) -> Array:
    """Return the covered share (h, w), 0 to 1, of each cell of a grid.

    Edges (n, 4) in cells form closed outlines. The area is on their left where y points up, as in
    ``edges``. Cell (row, column) covers column to column + 1 and row to row + 1; rows count along
    +y. The area outside the grid is cut off.

    The method is Green's theorem by cells. Edges are cut at all grid lines, so each piece lies in
    one cell. There it covers its height times the width to its right. In all cells further right it
    covers its height. The signed sum over an outline is the area inside.
    """
    height, width = shape
    if not height * width:  # all of it is outside
        return np.zeros(shape)
    start, end = _cut_at_grid_lines(edges)
    middle = (start + end) / 2
    column, row = np.floor(middle).astype(np.int64).T
    inside = (row >= 0) & (row < height) & (column < width)
    rise = (start[:, 1] - end[:, 1])[inside]
    part = np.where(column < 0, 0.0, middle[:, 0] - column)[inside]
    cell = row[inside] * (width + 1) + np.maximum(column[inside], 0)
    size = height * (width + 1)
    change: Array = np.bincount(cell, rise * (1 - part), size).astype(np.float64)
    change += np.bincount(cell + 1, rise * part, size)
    covered = np.cumsum(change.reshape(height, width + 1), axis=1)[:, :width]
    return np.clip(covered, 0, 1, out=covered)


def _cut_at_grid_lines(edges: Array) -> tuple[Array, Array]:
    """Cut edges (n, 4) wherever they cross whole x or y; return start and end points (m, 2)."""
    start, step = edges[:, :2], edges[:, 2:] - edges[:, :2]
    count = len(edges)
    whole = np.arange(count)
    owners, fractions = [whole, whole], [np.zeros(count), np.ones(count)]
    for axis in (0, 1):
        owner, line = _lines_between(start[:, axis], start[:, axis] + step[:, axis])
        owners.append(owner)
        fractions.append((line - start[owner, axis]) / step[owner, axis])
    owner, fraction = np.concatenate(owners), np.concatenate(fractions)
    order = np.lexsort((fraction, owner))
    owner, fraction = owner[order], fraction[order]
    points = start[owner] + fraction[:, None] * step[owner]
    same = owner[1:] == owner[:-1]
    return points[:-1][same], points[1:][same]


def _lines_between(a: Array, b: Array) -> tuple[NDArray[np.intp], Array]:
    """Return the whole numbers strictly between a (n,) and b (n,): pair indices, numbers (m,)."""
    first = np.floor(np.minimum(a, b)) + 1
    counts = np.maximum(np.ceil(np.maximum(a, b)) - first, 0).astype(np.intp)
    owner = np.repeat(np.arange(len(a)), counts)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    return owner, first[owner] + rank
