"""A field from an SVG drawing: its tape, its floor picture and its start.

The drawing is scaled from its viewBox to its width and height, in a unit of the standard or, where
they have none, in mm (``svg_page``). Its own (0, 0) is the origin of the map; x points right and y
**up**, while SVG's y points down. Every dark stroke (brightness below a half) is tape: the line, as
wide as its stroke, with its caps, joins and dashes. So is a light stroke on a dark floor
(``drawn_tape``).

Fills belong to the floor picture only. They give the floor its tone. On a light floor a **dark fill
is clutter**: the camera sees it, and the edge map does not contain it.

``data-start="x y theta"`` (mm, mm, degrees; y up) on the ``<svg>`` is the start pose, by default
the drawing's own (0, 0), or the page's middle if that is on its border;
``data-tape="50"`` says how wide the tape is, where one could doubt it (``question``). A map that
was drawn by driving has ``data-seen``: which of the floor was looked at.
"""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import numpy as np
import shapely

from robot.fields.drawing.coats import coats_of
from robot.fields.drawing.question import ask, refuse_invisible, refuse_thin
from robot.fields.drawing.shapes import MAX_MM, Page
from robot.fields.drawing.slits import without_slits
from robot.fields.drawing.svg_file import parse, read_bytes
from robot.fields.drawing.svg_shapes import read_page
from robot.fields.drawing.svg_values import SvgError, numbers, shown
from robot.fields.drawn_tape import DrawnTape, drawn_tape
from robot.fields.edges import outline
from robot.fields.field import Field, FieldError
from robot.fields.floor_picture import Extent, paint
from robot.fields.unseen_floor import SEEN
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
        return drawn_field(read_bytes(path), path.stem)
    except (FieldError, SvgError) as error:
        raise FieldError(f"{path}: {error}") from error


def field_of_drawing(content: str | bytes, name: str) -> Field:
    """Make a field from the content of a drawing's file.

    Raises:
        FieldError: the drawing cannot be used; one line says why.
    """
    try:
        return drawn_field(content.encode() if isinstance(content, str) else content, name)
    except (FieldError, SvgError) as error:
        raise FieldError(f"{name}: {error}") from error


@lru_cache(maxsize=8)
def drawn_field(content: bytes, name: str) -> Field:
    """Return the field that bytes draw: all that is done with a foreign file, in one function.

    Raises:
        SvgError: the content cannot be used.
        FieldError: its start is not on its floor.
    """
    try:
        return _painted(read_page(parse(content), TOLERANCE_MM), name)
    except shapely.errors.GEOSException as error:
        raise SvgError(str(error)) from error
    except RecursionError as error:
        raise SvgError("its style sheets are nested too deeply") from error


def _painted(page: Page, name: str) -> Field:
    coats = coats_of(page, TOLERANCE_MM)
    tape = drawn_tape(coats)
    extent = _extent(page)
    _check_widths(tape, page)
    area = _within(tape, extent, page)
    ask(page.size, tape.kinds[0].width * 1000, page.tape)
    return Field(
        name=name,
        floor=paint(extent, [coat.layer for coat in coats]),
        edges=outline(area),
        tape=tape.kinds,
        start=_start(page.start, extent),
        notes=page.notes,
        seen=_seen(page.notes.get(SEEN, "")),
    )


def _check_widths(tape: DrawnTape, page: Page) -> None:
    for width in (kind.width * 1000 for kind in tape.kinds):
        if width == 0:
            refuse_invisible(page.size)
        if width < TAPE_MM[0]:
            refuse_thin(page.size, width, TAPE_MM)


def _within(tape: DrawnTape, extent: Extent, page: Page) -> shapely.Geometry:
    """Return the tape on the floor, its outlines without false corners.

    Coordinates are snapped to nanometres. Then lines that continue each other up to a rounding
    error are one, and a ring can begin at its lowest left point, which is a true corner.
    """
    widest = max((kind.width for kind in tape.kinds), default=0.0)
    on_floor = shapely.intersection(without_slits(tape.area, widest), shapely.box(*extent))
    areas = [part for part in shapely.get_parts(on_floor) if part.geom_type == "Polygon"]
    snapped = shapely.set_precision(shapely.union_all(areas), 1e-9)
    tidy = shapely.simplify(shapely.normalize(snapped), MERGED_M)
    if shapely.area(tidy) < 1e-6:
        if page.hairlines:
            refuse_invisible(page.size)
        raise SvgError(
            "there is no tape: at least one dark stroke (brightness below half) is due, or a light "
            "one on a dark fill"
        )
    return tidy


def _extent(page: Page) -> Extent:
    left, top = -page.origin[0] / 1000, page.origin[1] / 1000
    return left, top - page.size.height / 1000, left + page.size.width / 1000, top


def _start(text: str, extent: Extent) -> Pose2:
    xmin, ymin, xmax, ymax = extent
    if not text.strip():
        # Where the origin is a corner of the page, as Inkscape's, nobody means to start there.
        inside = min(-xmin, xmax, -ymin, ymax) > MERGED_M
        return Pose2() if inside else Pose2((xmin + xmax) / 2, (ymin + ymax) / 2)
    values = numbers(text)
    if values is None or len(values) != 3:
        raise SvgError(f"data-start is {shown(text)}; valid are x [mm], y [mm], theta [degrees]")
    x, y, degrees = values
    if not ymin <= y / 1000 <= ymax and ymin <= -y / 1000 <= ymax:
        raise SvgError(
            f"data-start is {shown(text)}, which is not on the floor: its y points up, and that of "
            f"drawing programs down; was {x:g} {-y:g} {-degrees:z.6g} meant?"
        )
    return Pose2(x / 1000, y / 1000, math.radians(degrees))


def _seen(text: str) -> tuple[Array, ...]:
    outlines = []
    for part in text.split(";") if text.strip() else ():
        values = numbers(part) or [math.inf]
        if len(values) < 6 or len(values) % 2 or not max(map(abs, values)) <= MAX_MM:
            raise SvgError(
                f"{SEEN} has {shown(part)}; valid are x and y of three corners or more, up to "
                f"{MAX_MM:g} mm, and a semicolon between outlines"
            )
        outlines.append(np.array(values).reshape(-1, 2) / 1000)
    return tuple(outlines)
