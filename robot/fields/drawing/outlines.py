"""The lines of SVG's shapes: paths, boxes, ellipses and polygons, flattened to straight lines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from robot.fields.drawing.curves import flatten
from robot.fields.drawing.path_data import FARTHEST, PathReader, Segment, Subpath, ellipse_arc
from robot.fields.drawing.strokes import Polyline
from robot.fields.drawing.svg_values import SvgError, numbers, shown
from robot.geometry import Array

Dimension = Callable[[str], float | None]
"""A length of the shape by its name, in its own units; None if it is automatic."""

SHAPES = ("path", "rect", "circle", "ellipse", "line", "polyline", "polygon")


def subpaths(kind: str, data: str, dimension: Dimension) -> list[Subpath]:
    """Return the lines of a shape; ``data`` is its ``d`` or its ``points``.

    Raises:
        SvgError: the data cannot be read.
    """
    if kind == "path":
        return list(PathReader(data).subpaths())
    if kind in ("polyline", "polygon"):
        return _polygon(data, closed=kind == "polygon")
    if kind == "line":
        start, end = (
            complex(_known(dimension, f"x{k}"), _known(dimension, f"y{k}")) for k in (1, 2)
        )
        return [Subpath(start, [Segment(start, end)])]
    if kind == "rect":
        return _rectangle(dimension)
    centre = complex(_known(dimension, "cx"), _known(dimension, "cy"))
    if kind == "circle":
        return _ellipse(centre, *2 * [_known(dimension, "r")])
    return _ellipse(centre, *_radii(dimension))


def _known(dimension: Dimension, name: str) -> float:
    value = dimension(name)
    return 0.0 if value is None else value


def _radii(dimension: Dimension) -> tuple[float, float]:
    """Return both radii: one that is not given, or cannot be, is the other one."""
    given = [dimension(name) for name in ("rx", "ry")]
    rx, ry = (value if value is not None and value >= 0 else None for value in given)
    return (rx if rx is not None else ry or 0.0), (ry if ry is not None else rx or 0.0)


def _polygon(text: str, closed: bool) -> list[Subpath]:
    values = numbers(text) if text.strip(", \t\r\n") else []
    if values is None:
        raise SvgError(f"points are {shown(text)}; valid are pairs of numbers: x, y, x, y ...")
    places = [complex(x, y) for x, y in zip(values[::2], values[1::2], strict=False)]
    if not places:
        return []
    path = Subpath(places[0], closed=closed)
    for place in places[1:]:
        path.line_to(place)
    return [path]


def _ellipse(centre: complex, rx: float, ry: float) -> list[Subpath]:
    """Return an ellipse from its right end on, first downward, as four arcs."""
    if not (rx > 0 and ry > 0):
        return []
    path = Subpath(centre + rx, closed=True)
    quarters = [centre + 1j * ry, centre - rx, centre - 1j * ry, centre + rx]
    for index, end in enumerate(quarters):
        _corner(path, centre, complex(rx, ry), index, end)
    return [path]


def _corner(path: Subpath, centre: complex, radii: complex, quarter: int, end: complex) -> None:
    """Draw a quarter of an ellipse; quarter 0 begins at its right end."""
    curve = ellipse_arc(centre, radii, 0.0, quarter * math.pi / 2, math.pi / 2)
    path.segments.append(Segment(path.end, end, curve))


def _rectangle(dimension: Dimension) -> list[Subpath]:
    x, y = _known(dimension, "x"), _known(dimension, "y")
    width, height = _known(dimension, "width"), _known(dimension, "height")
    if not (width > 0 and height > 0):
        return []
    rx, ry = _radii(dimension)
    rx, ry = min(rx, width / 2), min(ry, height / 2)
    right, bottom = x + width, y + height
    if not (rx > 0 and ry > 0):
        path = Subpath(complex(x, y), closed=True)
        for corner in (complex(right, y), complex(right, bottom), complex(x, bottom)):
            path.line_to(corner)
        return [path]
    path, radii = Subpath(complex(x + rx, y), closed=True), complex(rx, ry)
    path.line_to(complex(right - rx, y))
    _corner(path, complex(right - rx, y + ry), radii, -1, complex(right, y + ry))
    path.line_to(complex(right, bottom - ry))
    _corner(path, complex(right - rx, bottom - ry), radii, 0, complex(right - rx, bottom))
    path.line_to(complex(x + rx, bottom))
    _corner(path, complex(x + rx, bottom - ry), radii, 1, complex(x, bottom - ry))
    path.line_to(complex(x, y + ry))
    _corner(path, complex(x + rx, y + ry), radii, 2, complex(x + rx, y))
    return [path]


def polylines(paths: Iterable[Subpath], half_width: float, tolerance: float) -> Iterator[Polyline]:
    """Flatten the curves of paths, fine enough for a stroke drawn along them (``flatten``).

    Raises:
        SvgError: a coordinate is absurd, or a curve needs absurdly many lines.
    """
    for path in paths:
        if path.segments or path.closed:
            yield _polyline(path, half_width, tolerance)


def _polyline(path: Subpath, half_width: float, tolerance: float) -> Polyline:
    if all(segment.curve is None for segment in path.segments):
        places = [path.start, *(segment.end for segment in path.segments)]
        points = _finite(np.array([(place.real, place.imag) for place in places]))
    else:
        parts = [_flattened(segment, half_width, tolerance) for segment in path.segments]
        # Each part begins where the previous one ended.
        points = np.vstack([parts[0][:1], *[part[1:] for part in parts]])
    if path.closed and len(points) > 1 and (points[0] == points[-1]).all():
        points = points[:-1]
    return Polyline(points, path.closed)


def _flattened(segment: Segment, half_width: float, tolerance: float) -> Array:
    curve = segment.curve
    ends = np.array([(place.real, place.imag) for place in (segment.start, segment.end)])
    if curve is None:
        return _finite(ends)
    try:
        points = flatten(lambda t: _finite(curve(t)), half_width, tolerance)
    except SvgError:
        raise
    except ValueError as error:
        raise SvgError(str(error)) from error
    points[0], points[-1] = ends
    return points


def _finite(points: Array) -> Array:
    if not (np.abs(points) <= FARTHEST).all():
        raise SvgError("a coordinate is too large or no number")
    return points
