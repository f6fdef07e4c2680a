"""Drawings from a seed: the same seed gives the same drawing, byte for byte."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import shapely

from robot.fields.generator.marks import MARKS
from robot.fields.generator.names import PREFIX
from robot.fields.generator.outlines import GRID, OUTLINES, inside
from robot.fields.generator.strokes import TAPE, TapeLine

SMALLEST, LARGEST = 600, 2950
"""Sides of the outermost tape's centre line [mm]; with the tape's width, 0.65 to 3 m."""

MARGIN = 250
"""Floor beyond the centre line of the outermost tape [mm], as in the drawings of maps/."""

SYMMETRIC = 0.3
"""Share of the fields that are made symmetric on purpose: half a turn does not change them."""

_ALIKE = 30
"""Lines of tape cross, or are farther apart than twice this [mm]: nobody leaves narrow slits."""
_SLIT = 2500
"""Largest area of a slit between lines that cross at a slant [mm²]."""
_CROSSING = 8000
"""Lines that overlap by more than this in one place lie along each other [mm²]."""
_CLEAR = (100, 60, 25, 1)
"""Distances of the start from tape [mm]; the first one for which there is room is used."""


@lru_cache(maxsize=64)
def drawing(seed: int) -> str:
    """Return the SVG drawing of a seed: in millimetres, with 50 mm tape, starting on free floor."""
    rng = np.random.default_rng([seed, 0xF1E1D])
    width, height = _size(rng)
    same = bool(rng.random() < SYMMETRIC)
    outline, name = _outline(rng, width, height, same)
    area = inside(outline, width, height)
    strokes, names = _marked(rng, outline, area, same)
    title = f"{PREFIX}{seed}: {' '.join([name, *names])}{', symmetric' if same else ''}"
    return _page(title, strokes, _start(rng, strokes, area))


def _size(rng: np.random.Generator) -> tuple[float, float]:
    """Draw the width and height of the outermost line [mm]; small and large are equally likely."""
    long = np.exp(rng.uniform(np.log(SMALLEST), np.log(LARGEST)))
    short = max(long * rng.uniform(0.55, 1.0), SMALLEST)
    sides = [float(GRID * max(round(side / GRID), SMALLEST // GRID)) for side in (long, short)]
    return (sides[0], sides[1]) if rng.random() < 0.6 else (sides[1], sides[0])


def _outline(
    rng: np.random.Generator, width: float, height: float, same: bool
) -> tuple[list[TapeLine], str]:
    draw = OUTLINES[int(rng.choice(len(OUTLINES), p=[share for _, share in OUTLINES]))][0]
    return draw(rng, width, height, same), draw.__name__.replace("_", "-")


def _marked(
    rng: np.random.Generator, outline: list[TapeLine], area: shapely.Geometry, same: bool
) -> tuple[list[TapeLine], list[str]]:
    """Return the outline with marks in it, and the names of the marks.

    Their number is random, from none up to one plus one for each 0.4 m² of the area, but at most 7.
    There are fewer if there is no room. A symmetric field has half of them, each with its copy
    after half a turn.
    """
    wanted = int(rng.integers(0, 2 + min(int(shapely.area(area) / 0.4e6), 6)))
    if same:
        wanted = (wanted + 1) // 2
    strokes = list(outline)
    names: list[str] = []
    for _ in range(8 * wanted):
        if len(names) == wanted:
            break
        draw = MARKS[int(rng.choice(len(MARKS), p=[share for _, share in MARKS]))][0]
        more = draw(rng, area)
        if same:
            more += [item.turned() for item in more]
        laid = _laid(strokes, more)
        if laid and _can_be_laid(laid, area):
            strokes = laid
            names.append(draw.__name__)
    return strokes, names


def _laid(strokes: list[TapeLine], more: list[TapeLine]) -> list[TapeLine]:
    """Return old and new lines; none if there is no new line, or it lies along another line."""
    laid = list(strokes)
    for item in more:
        tape = shapely.union_all([other.area for other in laid])
        shared = shapely.get_parts(shapely.intersection(tape, item.area))
        if max((part.area for part in shared), default=0.0) > _CROSSING:
            return []
        laid.append(item)
    return laid if more else []


def _can_be_laid(strokes: list[TapeLine], area: shapely.Geometry) -> bool:
    """Return whether the lines have no slits between them and leave enough floor."""
    tape = shapely.union_all([stroke.area for stroke in strokes])
    closed = shapely.buffer(shapely.buffer(tape, _ALIKE), -_ALIKE)
    slits = shapely.get_parts(shapely.difference(closed, shapely.buffer(tape, 0.5)))
    widest = max((slit.area for slit in slits), default=0.0)
    free = shapely.area(shapely.difference(area, tape))
    return widest < _SLIT and bool(free > 0.5 * shapely.area(area))


def _start(
    rng: np.random.Generator, strokes: list[TapeLine], area: shapely.Geometry
) -> tuple[float, float, float]:
    """Return the start's x, y [mm] and heading [degrees]: the clear point nearest to the middle."""
    tape = shapely.union_all([stroke.area for stroke in strokes])
    heading = float(rng.integers(-11, 13) * 15)
    middle = shapely.centroid(area)
    for margin in _CLEAR:
        free = shapely.difference(area, shapely.buffer(tape, margin))
        if not free.is_empty:
            x, y = shapely.shortest_line(free, middle).coords[0]
            return float(np.round(x)), float(np.round(y)), heading
    raise AssertionError("a generated field has free floor")


def _page(title: str, strokes: list[TapeLine], start: tuple[float, float, float]) -> str:
    lines = shapely.union_all([item.line for item in strokes])
    xmin, ymin, xmax, ymax = shapely.bounds(lines)
    left, top = np.floor(xmin) - MARGIN, np.floor(-ymax) - MARGIN
    width = np.ceil(xmax) + MARGIN - left
    height = np.ceil(-ymin) + MARGIN - top
    shown = f"{start[0]:g} {start[1]:g} {start[2]:g}"
    drawn = "\n".join(f"    {stroke.element()}" for stroke in strokes)
    return f"""\
<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}mm" height="{height:g}mm" \
viewBox="{left:g} {top:g} {width:g} {height:g}" data-start="{shown}">
  <title>{title}</title>
  <rect x="{left:g}" y="{top:g}" width="{width:g}" height="{height:g}" fill="#d7d5cf"/>
  <!-- Inside, y points up as it does in the map. -->
  <g transform="scale(1 -1)" fill="none" stroke="#202225" stroke-width="{TAPE}">
{drawn}
  </g>
</svg>
"""
