"""What of a drawing can be edited: its strips of tape, as lines and arcs, and the rest as areas."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import shapely

from app.features.field_editor.arcs import fitted
from app.features.field_editor.messages import (
    EditableDrawingMessage,
    EditableFillMessage,
    EditableStrokeMessage,
)
from app.languages.marking import phrase
from robot.fields.drawing.question import LEFT_OUT
from robot.fields.drawing.shapes import Page, Shape
from robot.fields.drawing.svg_file import parse, read_bytes
from robot.fields.drawing.svg_shapes import read_page
from robot.fields.drawing.svg_values import SvgError
from robot.fields.field import FieldError
from robot.fields.svg_field import TOLERANCE_MM, field_of_drawing
from robot.geometry import Array

CLIPPED = phrase("Parts that a clip hides are drawn whole.")


def editable(path: Path) -> EditableDrawingMessage:
    """Return a drawing as the editor takes it.

    Raises:
        FieldError: the drawing cannot be used; one line says why.
    """
    try:
        content = read_bytes(path)
        field = field_of_drawing(content, path.stem)
        page = read_page(parse(content), TOLERANCE_MM)
    except SvgError as error:
        raise FieldError(f"{path.stem}: {error}") from error
    left, top = -page.origin[0], page.origin[1]
    strokes, fills, remarks = [], [], [words for words in (page.notes.get(LEFT_OUT),) if words]
    if page.background is not None:
        box = _around(page.size.width, page.size.height)
        fills.append(_fill([_on_map(box, page)], page.background.grey, page.background.alpha))
    for shape in page.shapes:
        if shape.clip is not None and not _shows_whole(shape):
            remarks.append(CLIPPED)
        places = [_on_map(place, page) for place in shape.places()]
        if shape.fill is not None:
            alpha = shape.fill.alpha * math.prod(fade.opacity for fade in shape.fades)
            fills.append(_fill(places, shape.fill.grey, alpha))
        if shape.stroke is not None and shape.stroke.alpha > 0:
            strokes += _strokes(shape, places)
    return EditableDrawingMessage(
        left=left,
        bottom=top - page.size.height,
        width=page.size.width,
        height=page.size.height,
        start=(field.start.x * 1000, field.start.y * 1000, math.degrees(field.start.theta)),
        strokes=strokes,
        fills=fills,
        kept={
            name: text
            for name, text in page.notes.items()
            if name.startswith("data-") and name != "data-start"
        },
        remarks=list(dict.fromkeys(remarks)),
    )


def _strokes(shape: Shape, places: list[Array]) -> list[EditableStrokeMessage]:
    matrix = shape.page_from_shape[:, :2]
    scale = math.sqrt(abs(float(np.linalg.det(matrix))))
    assert shape.stroke is not None
    return [
        EditableStrokeMessage(
            nodes=_rounded(fitted(place, closed=line.closed)),
            closed=line.closed,
            width=round(shape.pen.width * scale, 3),
            grey=_level(shape.stroke.grey),
            dashes=[round(length * scale, 3) for length in shape.pen.dashes],
        )
        for line, place in zip(shape.lines, places, strict=True)
        if len(place) > 1
    ]


def _fill(rings: list[Array], grey: float, alpha: float) -> EditableFillMessage:
    outlines = [ring.round(3).tolist() for ring in rings if len(ring) > 2]
    return EditableFillMessage(rings=outlines, grey=_level(grey), opacity=round(alpha, 4))


def _rounded(nodes: list[tuple[float, float, float]]) -> list[tuple[float, float, float]]:
    return [(round(x, 3), round(y, 3), round(bend, 6)) for x, y, bend in nodes]


def _level(grey: float) -> int:
    return min(255, max(0, round(grey)))


def _around(width: float, height: float) -> Array:
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def _on_map(places: Array, page: Page) -> Array:
    """Return places of the page [mm] in the map frame [mm]."""
    return (places - page.origin) * (1.0, -1.0)


def _shows_whole(shape: Shape) -> bool:
    points = [shapely.MultiPoint(place) for place in shape.places() if len(place)]
    return shape.clip is None or all(bool(shapely.covers(shape.clip, point)) for point in points)
