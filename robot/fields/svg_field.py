"""A field from an SVG drawing: its tape, its floor picture and its start.

The drawing is in millimetres, scaled from its viewBox to its width and height (mm, cm, in, or
without a unit: mm). Its own (0, 0) is the origin of the map; x points right and y **up**, while
SVG's y points down. Every dark stroke (brightness below a half) is tape: the line, as wide as its
stroke, with its caps, joins and dashes. So is a light stroke on a dark floor (``drawn_tape``).

Fills belong to the floor picture only. They give the floor its tone. On a light floor a **dark fill
is clutter**: the camera sees it, and the edge map does not contain it.

``data-start="x y theta"`` (mm, mm, degrees; y up) on the ``<svg>`` is the start pose.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np
import shapely

from robot.fields.drawing.strokes import fill_area, stroke_area
from robot.fields.drawing.svg_file import SvgError, SvgFile, check_svg, numbers, read_svg, shown
from robot.fields.drawing.svg_shapes import Ink, Page, Shape, read_page
from robot.fields.drawn_tape import Coat, DrawnTape, drawn_tape
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


@lru_cache(maxsize=8)
def _field(svg: SvgFile, name: str) -> Field:
    page = read_page(svg, TOLERANCE_MM)
    coats = list(_coats(page))
    tape = drawn_tape(coats)
    _check_widths(tape)
    extent = _extent(svg, page)
    return Field(
        name=name,
        floor=paint(extent, [coat.layer for coat in coats]),
        edges=outline(_within(tape.area, extent)),
        tape=tape.kinds,
        start=_start(svg.start),
    )


def _coats(page: Page) -> Iterator[Coat]:
    """Yield what is painted, in order and in the map frame: each shape's fill, then its stroke."""
    for shape in page.shapes:
        if shape.scale == 0 or not shape.lines:
            continue
        place = _map_from_shape(shape, page.origin)
        if shape.fill:
            area = fill_area([line.points for line in shape.lines], shape.even_odd)
            yield Coat(_layer(area, place, shape.fill))
        if shape.stroke:
            yield _stroke(shape, place, shape.stroke)


def _stroke(shape: Shape, place: Array, ink: Ink) -> Coat:
    _, high = TAPE_MM
    widest = shape.pen.width * shape.scale
    if widest > high:
        raise SvgError(f"a stroke is {widest:g} mm wide; valid is up to {high:g}")
    width = shape.pen.width * math.sqrt(abs(np.linalg.det(place[:, :2])))
    tolerance = TOLERANCE_MM / shape.scale
    try:
        area = shapely.union_all([stroke_area(line, shape.pen, tolerance) for line in shape.lines])
    except ValueError as error:
        raise SvgError(str(error)) from error
    # An odd number of lengths is taken twice, so each is a dash once.
    pattern = shape.pen.dashes[:: 2 - len(shape.pen.dashes) % 2]
    dash = max(pattern, default=0.0) * width / shape.pen.width if width else 0.0
    return Coat(_layer(area, place, ink), width, dash)


def _check_widths(tape: DrawnTape) -> None:
    low, high = TAPE_MM
    for kind in tape.kinds:
        if kind.width * 1000 < low:
            raise SvgError(
                f"a stroke of tape is {kind.width * 1000:g} mm wide; valid is {low:g} to {high:g}"
            )


def _layer(area: shapely.Geometry, place: Array, ink: Ink) -> Layer:
    moved = shapely.transform(area, lambda points: points @ place[:, :2].T + place[:, 2])
    return Layer(moved, ink.grey, ink.alpha)


def _map_from_shape(shape: Shape, origin: tuple[float, float]) -> Array:
    """Return the affine transform (2, 3) from a shape's units to the map [m]."""
    place = shape.page_from_shape.copy()
    place[:, 2] -= origin
    place *= [[0.001], [-0.001]]
    return place


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
        raise SvgError(
            "there is no tape: at least one dark stroke (brightness below half) is due, or a light "
            "one on a dark fill"
        )
    return tidy


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
