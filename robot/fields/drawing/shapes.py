"""The shapes of a drawing, as plain numbers: lines, paint, and where they show on the page."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import shapely

from robot.fields.drawing.strokes import Pen, Polyline, fill_area
from robot.fields.drawing.svg_page import PageSize
from robot.fields.drawing.svg_values import Ink, SvgError
from robot.geometry import Array

MAX_MM = 1e6
"""Larger coordinates are a mistake [mm]."""


@dataclass(frozen=True, slots=True)
class Fade:
    """A group that is painted as a whole, then laid over the rest with an opacity."""

    opacity: float
    number: int
    """Tells groups of one opacity from each other."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """One shape of a drawing; its lines are in its own units."""

    lines: tuple[Polyline, ...]
    page_from_shape: Array
    """(2, 3) affine transform from its own units to the page [mm]: from the top left, y down."""
    fill: Ink | None
    even_odd: bool
    stroke: Ink | None
    pen: Pen
    stroke_first: bool = False
    """Whether its fill is painted over its stroke."""
    clip: shapely.Geometry | None = None
    """The part of the page [mm] on which it shows; None is all of it."""
    fades: tuple[Fade, ...] = ()
    """The groups with an opacity in which it is, the outermost first."""

    @property
    def scale(self) -> float:
        """Largest length that one of the shape's own units has on the page [mm]."""
        return scale_of(self.page_from_shape)

    def clipped(self, area: shapely.Geometry) -> Shape:
        """Return the shape as it shows within an area of the page [mm]."""
        within = area if self.clip is None else shapely.intersection(self.clip, area)
        return replace(self, clip=within)

    def places(self) -> list[Array]:
        """Return the points (n, 2) of each line on the page [mm]."""
        matrix = self.page_from_shape
        return [line.points @ matrix[:, :2].T + matrix[:, 2] for line in self.lines]

    def filled_area(self) -> shapely.Geometry:
        """Return the area [mm] of its fill on the page."""
        area = moved(fill_area([line.points for line in self.lines], self.even_odd), self)
        return area if self.clip is None else shapely.intersection(area, self.clip)


@dataclass(frozen=True, slots=True)
class Page:
    """All shapes of a drawing, in the order of painting."""

    size: PageSize
    shapes: tuple[Shape, ...]
    background: Ink | None
    """What the whole page is painted with before."""
    start: str
    """Text of ``data-start``; empty if there is none."""
    tape: str
    """Text of ``data-tape``; empty if there is none."""
    notes: Mapping[str, str] = field(default_factory=dict)
    hairlines: bool = False
    """Whether lines have strokes of no width, which show nothing."""

    @property
    def origin(self) -> tuple[float, float]:
        """Position on the page [mm] of the drawing's own (0, 0)."""
        x, y = self.size.viewport.matrix[:, 2].tolist()
        return x, y


def scale_of(matrix: Array) -> float:
    """Return the largest length that a unit has after an affine transform (2, 3).

    Raises:
        SvgError: it is absurd.
    """
    if not (np.abs(matrix) <= MAX_MM).all():
        raise SvgError("a transform is too large or no number")
    (a, c, _), (b, d, _) = matrix.tolist()
    return (math.hypot(a + d, b - c) + math.hypot(a - d, b + c)) / 2


def moved(area: shapely.Geometry, shape: Shape) -> shapely.Geometry:
    """Return an area in a shape's own units on the page [mm]."""
    matrix = shape.page_from_shape
    return shapely.transform(area, lambda points: points @ matrix[:, :2].T + matrix[:, 2])


def unit_box(shapes: Iterable[Shape], page_from_units: Array) -> Array:
    """Return the transform (2, 3) from a unit square to the box around shapes, in some units.

    A box without an extent gives zeros.
    """
    places = [place for shape in shapes for place in shape.places() if len(place)]
    determinant = float(np.linalg.det(page_from_units[:, :2]))
    if not places or not abs(determinant) > 0:
        return np.zeros((2, 3))
    inverse = np.linalg.inv(page_from_units[:, :2])
    points = (np.vstack(places) - page_from_units[:, 2]) @ inverse.T
    low, high = points.min(axis=0), points.max(axis=0)
    return np.column_stack([np.diag(high - low), low])
