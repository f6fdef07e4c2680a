"""The shapes of a drawing with their paint, as plain numbers: the only user of svgelements.

Some features svgelements would silently draw otherwise than a browser (unknown colours become
black, percentages of a stroke's width, masks, markers, ...). They are refused by name instead.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import svgelements

from robot.fields.drawing.curves import flatten
from robot.fields.drawing.strokes import Pen, Polyline
from robot.fields.drawing.svg_file import SvgError, SvgFile, numbers, shown
from robot.geometry import Array

MAX_POINTS = 20_000
MAX_MM = 1e6
"""Larger coordinates are a mistake [mm]."""

_ONLY = {
    "clip-path": ("none",),
    "filter": ("none",),
    "marker": ("none",),
    "marker-end": ("none",),
    "marker-mid": ("none",),
    "marker-start": ("none",),
    "mask": ("none",),
    "opacity": ("1", "1.0", "100%"),
    "paint-order": ("normal", "fill", "fill stroke", "fill stroke markers"),
    "stroke-linecap": ("butt", "round", "square"),
    "stroke-linejoin": ("miter", "round", "bevel", "miter-clip", "arcs"),
    "vector-effect": ("none",),
}
"""Attributes that change what is drawn, with the values that are understood."""

_COLOUR = re.compile(
    r"#(?:[0-9a-f]{3,4}|[0-9a-f]{6}|[0-9a-f]{8})|(?:rgb|hsl)a?\([^()]*,[^()]*,[^()]*\)", re.I
)
_WIDTH = re.compile(r"\d*\.?\d+(?:[eE][+-]?\d+)?(?:px|mm|cm|in)?")


@dataclass(frozen=True, slots=True)
class Ink:
    """Paint of a fill or a stroke."""

    grey: float
    """Brightness 0 to 255: 0.299 R + 0.587 G + 0.114 B, as OpenCV converts colours to grey."""
    alpha: float
    """Opacity, 0 to 1."""


@dataclass(frozen=True, slots=True)
class Shape:
    """One shape of a drawing; its lines are in its own units."""

    lines: tuple[Polyline, ...]
    page_from_shape: Array
    """(2, 3) affine transform from its own units to the page [mm]: from the top left, y down."""
    fill: Ink | None
    even_odd: bool
    stroke: Ink | None
    pen: Pen

    @property
    def scale(self) -> float:
        """Largest length that one of the shape's own units has on the page [mm]."""
        return _scale(self.page_from_shape)


@dataclass(frozen=True, slots=True)
class Page:
    """All shapes of a drawing, in the order of painting."""

    shapes: tuple[Shape, ...]
    origin: tuple[float, float]
    """Position on the page [mm] of the drawing's own (0, 0)."""


def read_page(svg: SvgFile, tolerance: float) -> Page:
    """Read the shapes; curves and their strokes are within the tolerance [mm] on the page.

    Raises:
        SvgError: a part of the drawing cannot be understood; the message says what is valid.
    """
    try:
        root = svgelements.SVG.parse(
            io.BytesIO(svg.content), reify=False, ppi=25.4, on_error="raise"
        )
        origin = svgelements.Matrix(root.viewbox_transform).point_in_matrix_space((0, 0))
        with np.errstate(all="ignore"):  # numbers that are not finite are refused
            shapes = tuple(_shapes(root, tolerance))
    except SvgError:
        raise
    except Exception as error:  # svgelements may raise anything on a strange text
        reason = shown(str(error) or type(error).__name__)
        raise SvgError(f"a shape or an attribute cannot be read: {reason}") from error
    return Page(shapes, (float(origin.x), float(origin.y)))


def _shapes(root: Any, tolerance: float) -> Iterator[Shape]:
    points = 0
    for element in root.elements():
        values = element.values or {}
        _refuse_unknown(values)
        if not isinstance(element, svgelements.Shape) or not _visible(values):
            continue
        shape = _shape(element, values, tolerance)
        points += sum(len(line.points) for line in shape.lines)
        if points > MAX_POINTS:
            raise SvgError(f"more than {MAX_POINTS} points along its lines; draw less finely")
        yield shape


def _visible(values: dict[str, Any]) -> bool:
    return str(values.get("visibility", "visible")) == "visible"


def _refuse_unknown(values: dict[str, Any]) -> None:
    for name, valid in _ONLY.items():
        value = str(values.get(name, valid[0])).strip()
        if value not in valid:
            raise SvgError(f"{name} is {shown(value)}; valid are {', '.join(valid)}")


def _shape(element: Any, values: dict[str, Any], tolerance: float) -> Shape:
    m = element.transform
    matrix = np.array([[m.a, m.c, m.e], [m.b, m.d, m.f]], dtype=np.float64)
    stroke = _ink(element.stroke, values, "stroke")
    pen = _pen(element, values) if stroke else Pen(0.0)
    scale = _scale(matrix)
    lines: tuple[Polyline, ...] = ()
    if scale > 0:
        # A dash may end anywhere; its cap is square to a chord instead of to the curve.
        own_tolerance = tolerance / scale / (16 if pen.dashes else 1)
        lines = tuple(_lines(element.segments(transformed=False), pen.width / 2, own_tolerance))
    places = [line.points @ matrix[:, :2].T + matrix[:, 2] for line in lines]
    if not all((np.abs(place) <= MAX_MM).all() for place in places):
        raise SvgError(f"a shape lies further out than {MAX_MM / 1e6:g} km")
    return Shape(
        lines=lines,
        page_from_shape=matrix,
        fill=_ink(element.fill, values, "fill"),
        even_odd=values.get("fill-rule") == "evenodd",
        stroke=stroke,
        pen=pen,
    )


def _scale(matrix: Array) -> float:
    if not (np.abs(matrix) <= MAX_MM).all():
        raise SvgError("a transform is too large or no number")
    return float(np.linalg.norm(matrix[:, :2], 2))


def _ink(colour: Any, values: dict[str, Any], role: str) -> Ink | None:
    text = str(values.get(role, "none")).strip()
    _number(values, f"{role}-opacity", 1.0)
    if colour is None or colour.value is None or text == "transparent":
        return None
    # svgelements reads an unknown name of a colour as black.
    named = text.isalpha() and (colour.rgb != 0 or text.lower() == "black")
    if not named and not _COLOUR.fullmatch(text):
        raise SvgError(f"{role} is {shown(text)}; valid are none, #rrggbb, rgb(r, g, b) or a name")
    grey = 0.299 * colour.red + 0.587 * colour.green + 0.114 * colour.blue
    return Ink(grey, float(np.clip(colour.opacity, 0, 1))) if colour.opacity > 0 else None


def _pen(element: Any, values: dict[str, Any]) -> Pen:
    text = str(values.get("stroke-width", "1")).strip()
    if not _WIDTH.fullmatch(text):
        raise SvgError(f"stroke-width is {shown(text)}; valid is a number, or one in mm, cm, in")
    join = values.get("stroke-linejoin", "miter")
    return Pen(
        width=float(element.stroke_width),
        cap=values.get("stroke-linecap", "butt"),
        join=join if join in ("round", "bevel") else "miter",
        miter_limit=_number(values, "stroke-miterlimit", 4.0),
        dashes=_dashes(values),
        dash_offset=_number(values, "stroke-dashoffset", 0.0),
    )


def _number(values: dict[str, Any], name: str, default: float) -> float:
    text = str(values.get(name, default)).removesuffix("px")
    result = numbers(text)
    if result is None or len(result) != 1:
        raise SvgError(f"{name} is {shown(text)}; valid is a number")
    return result[0]


def _dashes(values: dict[str, Any]) -> tuple[float, ...]:
    text = str(values.get("stroke-dasharray", "none")).strip()
    if text == "none":
        return ()
    result = numbers(text)
    if not result or min(result) < 0:
        raise SvgError(f"stroke-dasharray is {shown(text)}; valid are none or lengths from 0")
    return tuple(result)


def _lines(segments: Any, half_width: float, tolerance: float) -> Iterator[Polyline]:
    """Cut a path where the pen is lifted, and flatten its curves."""
    parts: list[Array] = []
    for segment in segments:
        if isinstance(segment, svgelements.Move):
            yield from _line(parts, closed=False)
            parts = []
        elif isinstance(segment, svgelements.Close):
            yield from _line(parts, closed=True)
            parts = []
        else:
            parts.append(_points(segment, half_width, tolerance))
    yield from _line(parts, closed=False)


def _line(parts: list[Array], closed: bool) -> Iterator[Polyline]:
    if not parts:
        return
    # Each part begins where the previous one ended.
    points = np.vstack([parts[0][:1], *[part[1:] for part in parts]])
    if closed and (points[0] == points[-1]).all() and len(points) > 1:
        points = points[:-1]
    yield Polyline(points, closed)


def _points(segment: Any, half_width: float, tolerance: float) -> Array:
    ends = np.array([segment.start, segment.end], dtype=np.float64)
    if isinstance(segment, svgelements.Line):
        return _finite(ends)
    points = flatten(_curve(segment), half_width, tolerance)
    points[0], points[-1] = ends
    return points


def _curve(segment: Any) -> Callable[[Array], Array]:
    return lambda parameters: _finite(np.asarray(segment.npoint(parameters), dtype=np.float64))


def _finite(points: Array) -> Array:
    if not (np.abs(points) <= 1e9).all():
        raise SvgError("a coordinate is too large or no number")
    return points
