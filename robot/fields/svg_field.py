"""A field from an SVG drawing: its tape, its floor picture and its start.

The drawing is in millimetres, scaled from its viewBox to its width and height (mm, cm, in, or
without a unit: mm). Its own (0, 0) is the origin of the map; x points right and y **up**, while
SVG's y points down. Every dark stroke (brightness below a half) is tape: the line, as wide as its
stroke, with its caps and joins. All tape is united. Light paint over tape hides it.

Fills belong to the floor picture only. A light fill gives the floor its tone. A **dark fill is
clutter**: the camera sees it, and the edge map does not contain it.

``data-start="x y theta"`` (mm, mm, degrees; y up) on the ``<svg>`` is the start pose.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from robot.fields.drawing.strokes import fill_area, stroke_area
from robot.fields.drawing.svg_file import SvgError, SvgFile, check_svg, numbers, read_svg, shown
from robot.fields.drawing.svg_shapes import Ink, Page, Shape, read_page
from robot.fields.edges import outline
from robot.fields.field import Field, FieldError
from robot.fields.floor_picture import Extent, Layer, paint
from robot.geometry import Array, Pose2

TOLERANCE_MM = 0.08
"""Tolerance of flattened curves [mm], so that they stay within 0.1 mm after all rounding."""

MERGED_M = 1e-5
"""A corner that is closer to the line between its neighbours is removed [m]."""

TAPE_MM = (1.0, 1000.0)
"""Narrowest and widest tape [mm]."""

_DARK = 127.5
"""Half the brightness of white."""


def load_svg(path: Path) -> Field:
    """Read a drawing as a field with the name of its file.

    Raises:
        FieldError: the file is missing, broken or absurd, or draws no tape; one line says why.
    """
    try:
        return _field(read_svg(path), path.stem)
    except (FieldError, SvgError, shapely.errors.GEOSException) as error:
        raise FieldError(f"{path}: {error}") from error


def field_of_drawing(text: str, name: str) -> Field:
    """Make a field from a drawing's text.

    Raises:
        FieldError: the drawing cannot be used; one line says why.
    """
    try:
        return _field(check_svg(text.encode()), name)
    except (FieldError, SvgError, shapely.errors.GEOSException) as error:
        raise FieldError(f"{name}: {error}") from error


def _field(svg: SvgFile, name: str) -> Field:
    page = read_page(svg, TOLERANCE_MM)
    coats = list(_coats(page))
    tape = _tape(coats)
    extent = _extent(svg, page)
    return Field(
        name=name,
        floor=paint(extent, [coat.layer for coat in coats]),
        edges=outline(_within(tape, extent)),
        tape_width=_tape_width(coats),
        start=_start(svg.start),
    )


@dataclass(frozen=True, slots=True)
class _Coat:
    """A stroke or a fill on the floor."""

    layer: Layer
    width: float | None = None
    """Width of a stroke [m]; a fill has none."""

    @property
    def is_tape(self) -> bool:
        layer = self.layer
        on_paper = layer.grey * layer.alpha + 255 * (1 - layer.alpha)
        return self.width is not None and on_paper < _DARK

    @property
    def hides_tape(self) -> bool:
        return self.layer.grey * self.layer.alpha >= _DARK


def _coats(page: Page) -> Iterator[_Coat]:
    """Yield what is painted, in order and in the map frame: each shape's fill, then its stroke."""
    for shape in page.shapes:
        if shape.scale == 0 or not shape.lines:
            continue
        place = _map_from_shape(shape, page.origin)
        if shape.fill:
            area = fill_area([line.points for line in shape.lines], shape.even_odd)
            yield _Coat(_layer(area, place, shape.fill))
        if shape.stroke:
            yield _stroke(shape, place, shape.stroke)


def _stroke(shape: Shape, place: Array, ink: Ink) -> _Coat:
    low, high = TAPE_MM
    widest = shape.pen.width * shape.scale
    if widest > high:
        raise SvgError(f"a stroke is {widest:g} mm wide; valid is up to {high:g}")
    width = shape.pen.width * math.sqrt(abs(np.linalg.det(place[:, :2])))
    tolerance = TOLERANCE_MM / shape.scale
    try:
        area = shapely.union_all([stroke_area(line, shape.pen, tolerance) for line in shape.lines])
    except ValueError as error:
        raise SvgError(str(error)) from error
    coat = _Coat(_layer(area, place, ink), width)
    if coat.is_tape and width * 1000 < low:
        raise SvgError(f"a dark stroke is {width * 1000:g} mm wide; valid is {low:g} to {high:g}")
    return coat


def _layer(area: shapely.Geometry, place: Array, ink: Ink) -> Layer:
    moved = shapely.transform(area, lambda points: points @ place[:, :2].T + place[:, 2])
    return Layer(moved, ink.grey, ink.alpha)


def _map_from_shape(shape: Shape, origin: tuple[float, float]) -> Array:
    """Return the affine transform (2, 3) from a shape's units to the map [m]."""
    place = shape.page_from_shape.copy()
    place[:, 2] -= origin
    place *= [[0.001], [-0.001]]
    return place


def _tape(coats: list[_Coat]) -> shapely.Geometry:
    """Return the area of tape that is visible after all coats."""
    tape: shapely.Geometry = shapely.Polygon()
    fresh: list[shapely.Geometry] = []
    for coat in coats:
        if coat.is_tape:
            fresh.append(coat.layer.area)
        elif coat.hides_tape:
            # Light paint hides only the tape that was painted before it.
            tape = shapely.difference(shapely.union_all([tape, *fresh]), coat.layer.area)
            fresh = []
    return shapely.union_all([tape, *fresh])


def _within(tape: shapely.Geometry, extent: Extent) -> shapely.Geometry:
    """Return the tape on the floor, its outlines without false corners.

    Coordinates are snapped to nanometres. Then lines that continue each other up to a rounding
    error are one, and a ring can begin at its lowest left point, which is a true corner.
    """
    on_floor = shapely.intersection(tape, shapely.box(*extent))
    areas = [part for part in shapely.get_parts(on_floor) if part.geom_type == "Polygon"]
    snapped = shapely.set_precision(shapely.union_all(areas), 1e-9)
    tidy = shapely.simplify(shapely.normalize(snapped), MERGED_M)
    if shapely.area(tidy) < 1e-6:
        raise SvgError("there is no tape: at least one dark stroke (brightness below half) is due")
    return tidy


def _tape_width(coats: list[_Coat]) -> float:
    """Return the width of the strokes that cover the largest area of floor [m]."""
    covered: defaultdict[float, float] = defaultdict(float)
    for coat in coats:
        if coat.is_tape and coat.width is not None:
            covered[round(coat.width, 7)] += float(shapely.area(coat.layer.area))
    return max(covered, key=covered.__getitem__)


def _extent(svg: SvgFile, page: Page) -> Extent:
    left, top = -page.origin[0] / 1000, page.origin[1] / 1000
    return left, top - svg.height / 1000, left + svg.width / 1000, top


def _start(text: str) -> Pose2:
    if not text.strip():
        return Pose2()
    values = numbers(text)
    if values is None or len(values) != 3:
        raise SvgError(f"data-start is {shown(text)}; valid are x [mm], y [mm], theta [degrees]")
    x, y, degrees = values
    return Pose2(x / 1000, y / 1000, math.radians(degrees))
