"""Lines of tape: their text in the drawing, and their course as points."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import shapely

from robot.geometry import Array

TAPE = 50
"""Width of the tape [mm]."""

BEND = 125
"""Smallest radius of the centre line of bent tape [mm]; the inner edge bends with 100 mm."""

_ARC_STEP = math.radians(3)


@dataclass(frozen=True, slots=True)
class TapeLine:
    """One line of tape; millimetres, y up."""

    path: str
    """The line as SVG's path data."""
    line: shapely.LineString = field(repr=False)
    """The same line as points, accurate enough to keep lines apart."""
    dashes: str = ""
    """Lengths of dash and gap, as SVG's ``stroke-dasharray``; empty means no gaps."""
    half_turn: bool = False
    """Whether the line is drawn after half a turn about the field's middle."""

    @property
    def area(self) -> shapely.Geometry:
        """The area of the tape."""
        return shapely.buffer(self.line, TAPE / 2, cap_style="flat", join_style="mitre")

    def turned(self) -> TapeLine:
        """Return the same line after half a turn about the field's middle."""
        line = shapely.transform(self.line, np.negative)
        return TapeLine(self.path, line, self.dashes, not self.half_turn)

    def element(self) -> str:
        """Return the line as an element of the drawing."""
        dashes = f' stroke-dasharray="{self.dashes}"' if self.dashes else ""
        turn = ' transform="rotate(180)"' if self.half_turn else ""
        return f'<path d="{self.path}"{dashes}{turn}/>'


def bent(
    corners: Sequence[tuple[float, float]],
    radius: float = 0.0,
    *,
    closed: bool = False,
    dashes: str = "",
) -> TapeLine:
    """Return a line through corners [mm], each rounded with a radius [mm] as far as there is room.

    A corner without room for ``BEND`` stays sharp: tape cannot be laid more tightly.
    """
    points: Array = np.asarray(corners, dtype=np.float64).round(1)
    path: list[str] = []
    line: list[Array] = []
    for before, corner, after in _neighbours(points, closed):
        words, places = _corner(before, corner, after, radius)
        path.append(words)
        line.append(places)
    if closed:
        line.append(line[0][:1])
    text = f"M {' L '.join(path)}{' Z' if closed else ''}"
    return TapeLine(text, shapely.LineString(np.vstack(line)), dashes)


def oval(x: float, y: float, along_x: float, along_y: float) -> TapeLine:
    """Return an ellipse with this centre and these half axes [mm]."""
    turn = np.linspace(0, 2 * math.pi, 121)
    points = np.column_stack([x + along_x * np.cos(turn), y + along_y * np.sin(turn)])
    points[-1] = points[0]
    arc = f"A {along_x:g} {along_y:g} 0 0 1"
    text = f"M {x + along_x:g} {y:g} {arc} {x - along_x:g} {y:g} {arc} {x + along_x:g} {y:g} Z"
    return TapeLine(text, shapely.LineString(points))


def _neighbours(points: Array, closed: bool) -> Iterator[tuple[Array | None, Array, Array | None]]:
    count = len(points)
    for index in range(count):
        before = points[index - 1] if closed or index > 0 else None
        after = points[(index + 1) % count] if closed or index < count - 1 else None
        yield before, points[index], after


def _corner(
    before: Array | None, corner: Array, after: Array | None, radius: float
) -> tuple[str, Array]:
    """Return a corner's part of the path data, and its points (n, 2)."""
    sharp = f"{corner[0]:g} {corner[1]:g}", corner[None]
    if before is None or after is None:
        return sharp
    arriving, leaving = corner - before, after - corner
    way, onward = math.hypot(*arriving), math.hypot(*leaving)
    back, ahead = -arriving / way, leaving / onward
    turn = math.atan2(-back[0] * ahead[1] + back[1] * ahead[0], -float(back @ ahead))
    tangent = math.tan(abs(turn) / 2)
    radius = min(radius, min(way, onward) / 2 / max(tangent, 1e-9))
    if radius < BEND or abs(turn) < 1e-3:
        return sharp
    start, end = corner + radius * tangent * back, corner + radius * tangent * ahead
    sweep = 1 if turn > 0 else 0
    words = f"{_pair(start)} A {radius:.1f} {radius:.1f} 0 0 {sweep} {_pair(end)}"
    return words, _arc(start, -back, turn, radius)


def _arc(start: Array, heading: Array, turn: float, radius: float) -> Array:
    """Return points (n, 2) along an arc."""
    side = math.copysign(1, turn)
    middle = start + side * radius * np.array([-heading[1], heading[0]])
    first = math.atan2(*(start - middle)[::-1])
    angles = first + np.linspace(0, turn, max(2, math.ceil(abs(turn) / _ARC_STEP)))
    return middle + radius * np.column_stack([np.cos(angles), np.sin(angles)])


def _pair(point: Array) -> str:
    return f"{point[0]:.1f} {point[1]:.1f}"


def straight_parts(geometry: shapely.Geometry, shortest: float) -> list[TapeLine]:
    """Return the straight lines of a geometry's parts that have at least this length [mm]."""
    result = []
    for part in shapely.get_parts(geometry):
        if part.geom_type == "LineString" and part.length >= shortest:
            ends = [(x, y) for x, y in part.coords]
            result += [bent(pair) for pair in pairwise(ends)]
    return result
