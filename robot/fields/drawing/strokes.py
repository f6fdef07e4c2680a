"""The areas that strokes and fills cover: SVG 2, chapters 13.4 and 13.7.

A stroke is the union of a rectangle for each line, a joint where two lines meet, and a cap at each
end.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from robot.geometry import Array

MAX_DASHES = 10_000
LONGEST_DASH = 1e9
"""In units of the drawing; far longer ones overflow when they are added."""
_INSIDE = 0.01
"""Joints and caps overlap their lines by this share of the half width, to leave no hair gaps."""


def dashes(points: Array, closed: bool, pattern: tuple[float, ...], offset: float) -> list[Array]:
    """Return the drawn pieces, each (m, 2), of a line through points (n, 2), by SVG's rules.

    The pattern holds lengths of dash, gap, dash, gap ... in the unit of the points, not all 0. An
    odd number of lengths is taken twice. The line begins at the offset in the pattern. On a closed
    line, dashes that meet at its start are one.

    Raises:
        ValueError: a length is negative, or there would be absurdly many dashes.
    """
    wrong = [length for length in pattern if not 0 <= length <= LONGEST_DASH]
    if wrong:
        raise ValueError(f"a dash of length {wrong[0]:g}; valid is 0 to {LONGEST_DASH:g}")
    around = np.vstack([points, points[:1]]) if closed else points
    step = np.diff(around, axis=0)
    walked = np.concatenate([[0.0], np.cumsum(np.hypot(step[:, 0], step[:, 1]))])
    intervals = _intervals(walked[-1], pattern, offset)
    pieces = [_piece(around, walked, start, end) for start, end in intervals]
    if closed and len(pieces) > 1 and intervals[0][0] == 0 and intervals[-1][1] == walked[-1]:
        pieces[0] = np.vstack([pieces.pop(), pieces[0][1:]])
    return pieces


def _intervals(
    length: float, pattern: tuple[float, ...], offset: float
) -> list[tuple[float, float]]:
    """Return where dashes begin and end on a line of this length."""
    even = pattern if len(pattern) % 2 == 0 else pattern * 2
    period = sum(even)
    repeats = int(length / period) + 2
    if repeats * len(even) > 2 * MAX_DASHES:
        raise ValueError(f"more than {MAX_DASHES} dashes; valid are longer ones")
    marks = np.concatenate([[0.0], np.cumsum(even * repeats)]) - offset % period
    starts, ends = np.maximum(marks[:-1:2], 0), np.minimum(marks[1::2], length)
    return [(float(a), float(b)) for a, b in zip(starts, ends, strict=True) if a <= b]


def _piece(around: Array, walked: Array, start: float, end: float) -> Array:
    inside = (walked > start) & (walked < end)
    marks = np.concatenate([[start], walked[inside], [end]])
    return np.column_stack([np.interp(marks, walked, around[:, k]) for k in (0, 1)])


@dataclass(frozen=True, slots=True, eq=False)
class Polyline:
    """A chain of straight lines, open or closed."""

    points: Array
    """(n, 2); a closed chain does not repeat its first point."""
    closed: bool


@dataclass(frozen=True, slots=True)
class Pen:
    """How a line is drawn; names and meanings are SVG's."""

    width: float
    cap: str = "butt"
    """butt, round or square."""
    join: str = "miter"
    """miter, round or bevel."""
    miter_limit: float = 4.0
    dashes: tuple[float, ...] = ()
    """Lengths of dash, gap, dash, gap ...; an empty tuple, or only zeros, means no gaps."""
    dash_offset: float = 0.0


def stroke_area(line: Polyline, pen: Pen, tolerance: float) -> shapely.Geometry:
    """Return the area under a pen that follows a line; arcs are within the tolerance.

    All lengths are in the same unit.
    """
    pieces = [line]
    if any(pen.dashes):
        cut = dashes(line.points, line.closed, pen.dashes, pen.dash_offset)
        pieces = [Polyline(points, closed=False) for points in cut]
    return shapely.union_all([part for piece in pieces for part in _parts(piece, pen, tolerance)])


def _parts(line: Polyline, pen: Pen, tolerance: float) -> list[shapely.Geometry]:
    points = _without_repeats(line, tolerance / 100)
    half = pen.width / 2
    if len(points) < 2:
        return _dot(line.points[:1], pen, tolerance)
    around = np.vstack([points, points[:1]]) if line.closed else points
    along = np.diff(around, axis=0)
    along /= np.hypot(along[:, 0], along[:, 1])[:, None]
    parts = _rectangles(around, along, half)
    if line.closed:
        incoming = np.roll(along, 1, axis=0)
        return parts + _joints(points, incoming, along, pen, tolerance)
    parts += _joints(points[1:-1], along[:-1], along[1:], pen, tolerance)
    for end, outward in ((points[0], -along[0]), (points[-1], along[-1])):
        parts += _cap(end, outward, pen, tolerance)
    return parts


def _without_repeats(line: Polyline, closer: float) -> Array:
    """Remove points that are closer to the previous one: so short a line has no direction."""
    points = line.points
    if not (np.hypot(*np.diff(points, axis=0, append=points[:1]).T) <= closer).any():
        return points
    kept = [0]
    for i in range(1, len(points)):
        if math.dist(points[i], points[kept[-1]]) > closer:
            kept.append(i)
    if line.closed and len(kept) > 1 and math.dist(points[kept[-1]], points[0]) <= closer:
        kept.pop()
    return points[kept]


def _dot(points: Array, pen: Pen, tolerance: float) -> list[shapely.Geometry]:
    """Return the area of a line of no length: a disc or a square if the cap has an extent."""
    if not len(points) or pen.cap == "butt":
        return []
    right = np.array([1.0, 0.0])
    return _cap(points[0], right, pen, tolerance) + _cap(points[0], -right, pen, tolerance)


def _left(along: Array) -> Array:
    """Turn unit vectors (..., 2) by a quarter turn anticlockwise."""
    return np.stack([-along[..., 1], along[..., 0]], axis=-1)


def _rectangles(around: Array, along: Array, half: float) -> list[shapely.Geometry]:
    aside = half * _left(along)
    start, end = around[:-1], around[1:]
    corners = np.stack([start + aside, start - aside, end - aside, end + aside], axis=1)
    return _polygons(corners)


def _polygons(corners: Array) -> list[shapely.Geometry]:
    """Return one polygon for each of n corner lists (n, k, 2)."""
    return list(np.asarray(shapely.polygons(corners)))


def _joints(
    points: Array, incoming: Array, outgoing: Array, pen: Pen, tolerance: float
) -> list[shapely.Geometry]:
    """Fill the outer side of corners (n, 2) between directions (n, 2) in and out."""
    inward = outgoing - incoming
    bent = (inward != 0).any(axis=1)
    points, incoming, outgoing = points[bent], incoming[bent], outgoing[bent]
    inward = inward[bent] / np.hypot(*inward[bent].T)[:, None]
    half = pen.width / 2
    cross = incoming[:, 0] * outgoing[:, 1] - incoming[:, 1] * outgoing[:, 0]
    turn = np.arctan2(cross, (incoming * outgoing).sum(axis=1))
    # The outer side is on the right of a left turn; a turn of 180 degrees counts as a left turn.
    outer = np.where(turn > 0, -half, half)[:, None]
    first, last = outer * _left(incoming), outer * _left(outgoing)
    inner = points + _INSIDE * half * inward
    # At a slight bend, as in a flattened curve, the addition of a miter cannot be seen.
    slight = (half * turn**2 / 8 <= tolerance) & (np.abs(turn) < 1)
    # SVG's miter ratio is 1 / sin(half the angle between the lines).
    within = np.cos(turn / 2) * pen.miter_limit >= 1
    mitered = slight | (within & (pen.join == "miter"))
    rounded = ~mitered & (pen.join == "round")
    corners = np.stack([inner, points + first, points + (first + last) / 2, points + last], axis=1)
    reach = 1 / np.cos(turn[mitered] / 2) ** 2
    corners[mitered, 2] = points[mitered] + (first + last)[mitered] / 2 * reach[:, None]
    parts = _polygons(corners[~rounded])
    for i in np.flatnonzero(rounded):
        parts.append(_sector(points[i], inner[i], first[i], turn[i], tolerance))
    return parts


def _cap(end: Array, outward: Array, pen: Pen, tolerance: float) -> list[shapely.Geometry]:
    if pen.cap == "butt":
        return []
    half = pen.width / 2
    aside = half * _left(outward)
    inner = end - _INSIDE * half * outward
    if pen.cap == "round":
        return [_sector(end, inner, -aside, math.pi, tolerance)]
    ahead = half * outward
    corners = [inner - aside, end + ahead - aside, end + ahead + aside, inner + aside]
    return [shapely.Polygon(corners)]


def _sector(
    centre: Array, inner: Array, first: Array, turn: float, tolerance: float
) -> shapely.Geometry:
    """Return the part of a disc that a radius sweeps from ``first`` through a turn [rad]."""
    radius = math.hypot(*first)
    steepest = 2 * math.acos(max(1 - tolerance / radius, 0.5))
    angles = np.linspace(0, turn, 1 + math.ceil(abs(turn) / steepest))
    c, s = np.cos(angles), np.sin(angles)
    arc = np.column_stack([c * first[0] - s * first[1], s * first[0] + c * first[1]])
    return shapely.Polygon(np.vstack([inner, centre + arc]))


def fill_area(outlines: Sequence[Array], even_odd: bool) -> shapely.Geometry:
    """Return the area inside outlines, each (n, 2) and closed by a straight line if it is open.

    The outlines may cross each other and themselves. They are cut into faces. With ``even_odd``, a
    face is inside if the outlines wind around it an odd number of times. Without it, a face is
    inside if that number is not zero.
    """
    closed = [np.vstack([points, points[:1]]) for points in outlines if len(points) > 2]
    if len(closed) == 1 and shapely.is_valid(single := shapely.Polygon(closed[0])):
        return single
    lines = shapely.union_all([shapely.LineString(points) for points in closed])
    faces = shapely.get_parts(shapely.polygonize([lines]))
    if not len(faces):
        return shapely.Polygon()
    inside = shapely.get_coordinates(shapely.point_on_surface(faces))
    winding = sum((_winding(points, inside) for points in closed), np.zeros(len(faces), np.int64))
    # Faces share whole sides: to join them takes no search for crossings.
    return shapely.coverage_union_all(faces[winding % 2 == 1 if even_odd else winding != 0])


def _winding(outline: Array, places: Array) -> NDArray[np.int64]:
    """Return how often a closed outline (n, 2) winds anticlockwise around points (m, 2).

    The winding number is the number of lines that cross a ray to the right of the point upward,
    minus those that cross it downward (Sunday 2001).
    """
    start, step = outline[:-1], np.diff(outline, axis=0)
    winding = np.zeros(len(places), np.int64)
    for i, (x, y) in enumerate(places):
        above = outline[:, 1] > y
        crossing = above[1:].astype(np.int64) - above[:-1]
        area = step[:, 0] * (y - start[:, 1]) - step[:, 1] * (x - start[:, 0])
        winding[i] = crossing[crossing * area > 0].sum()
    return winding
