"""Outlines of a generated field: rooms, rectangles, curves, or only streets that cross."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import shapely

from robot.fields.generator.strokes import BEND, TapeLine, bent, oval

GRID = 50
"""Corners lie on multiples of this [mm]."""

NOTCH = 200
"""Smallest side of a corner that a room lacks [mm]."""

Corner = tuple[float, float]
Draw = Callable[[np.random.Generator, float, float, bool], list[TapeLine]]
"""Draws an outline, from a random generator, width and height [mm], and whether half a turn must
change nothing."""


def rectangle(
    _rng: np.random.Generator, width: float, height: float, _same: bool
) -> list[TapeLine]:
    """Draw a rectangle."""
    return [bent(_box(width, height), closed=True)]


def square(_rng: np.random.Generator, width: float, height: float, _same: bool) -> list[TapeLine]:
    """Draw a square with the smaller of width and height."""
    side = min(width, height)
    return [bent(_box(side, side), closed=True)]


def room(rng: np.random.Generator, width: float, height: float, same: bool) -> list[TapeLine]:
    """Draw a rectangle that lacks some of its corners."""
    return [bent(_room(rng, width, height, same), closed=True)]


def rounded_room(
    rng: np.random.Generator, width: float, height: float, same: bool
) -> list[TapeLine]:
    """Draw a room with bends in place of corners, where there is space for them."""
    return [bent(_room(rng, width, height, same), float(rng.integers(BEND, 250)), closed=True)]


def rounded(rng: np.random.Generator, width: float, height: float, _same: bool) -> list[TapeLine]:
    """Draw a rectangle with bends in place of corners."""
    widest = max(BEND + 1, int(min(width, height) / 2))
    return [bent(_box(width, height), float(rng.integers(BEND, widest)), closed=True)]


def ellipse(_rng: np.random.Generator, width: float, height: float, _same: bool) -> list[TapeLine]:
    """Draw an oval that nowhere bends more tightly than tape can be laid."""
    long, short = sorted((width / 2, height / 2), reverse=True)
    short = max(short, np.ceil(np.sqrt(BEND * long)))
    return [oval(0, 0, *((long, short) if width >= height else (short, long)))]


def streets(rng: np.random.Generator, width: float, height: float, same: bool) -> list[TapeLine]:
    """Draw two or three streets in each direction, which cross and have free ends."""
    result = []
    for long, across, lies in ((width, height, True), (height, width, False)):
        for street_place in _street_places(rng, across, same):
            begin, end = -long / 2, long / 2
            if not same:
                begin += _grid(rng.uniform(0, 0.2) * long)
                end -= _grid(rng.uniform(0, 0.2) * long)
            ends = [(begin, street_place), (end, street_place)]
            result.append(bent(ends if lies else [(y, x) for x, y in ends]))
    return result


OUTLINES: tuple[tuple[Draw, float], ...] = (
    (rectangle, 0.2),
    (square, 0.07),
    (room, 0.22),
    (rounded_room, 0.1),
    (rounded, 0.16),
    (ellipse, 0.13),
    (streets, 0.12),
)
"""The outlines, each with its share of the fields."""


def inside(outline: list[TapeLine], width: float, height: float) -> shapely.Geometry:
    """Return the area that an outline encloses; for streets, their whole box."""
    if len(outline) == 1 and outline[0].line.is_closed:
        return shapely.Polygon(outline[0].line.coords)
    return shapely.box(-width / 2, -height / 2, width / 2, height / 2)


def _street_places(rng: np.random.Generator, across: float, same: bool) -> list[float]:
    """Return where streets begin along a side [mm], at least about 0.2 m apart."""
    count = 2 if across < 900 else int(rng.integers(2, 4))
    slot = across / count
    loose = max(slot / 2 - 100, 0)
    places = [(n + 0.5) * slot - across / 2 + rng.uniform(-loose, loose) for n in range(count)]
    if same:
        places = [(a - b) / 2 for a, b in zip(places, reversed(places), strict=True)]
    return [_grid(place) for place in places]


def _room(rng: np.random.Generator, width: float, height: float, same: bool) -> list[Corner]:
    free: shapely.Geometry = shapely.box(-width / 2, -height / 2, width / 2, height / 2)
    signs = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    count = 1 if same else int(rng.integers(1, 4))
    for place in rng.permutation(4)[:count]:
        size = [max(NOTCH, _grid(rng.uniform(0.2, 0.45) * side)) for side in (width, height)]
        notch = _notch(signs[place], size, width, height)
        free = shapely.difference(free, notch)
        if same:
            free = shapely.difference(free, shapely.transform(notch, np.negative))
    ring = shapely.simplify(shapely.orient_polygons(free), 0.1)
    return [(x, y) for x, y in shapely.get_coordinates(ring)[:-1].tolist()]


def _notch(
    sign: tuple[int, int], size: list[float], width: float, height: float
) -> shapely.Geometry:
    x, y = sign[0] * width / 2, sign[1] * height / 2
    left, right = sorted((x, x - sign[0] * size[0]))
    low, high = sorted((y, y - sign[1] * size[1]))
    return shapely.box(left, low, right, high)


def _box(width: float, height: float) -> list[Corner]:
    x, y = width / 2, height / 2
    return [(-x, -y), (x, -y), (x, y), (-x, y)]


def _grid(length: float) -> float:
    return float(GRID * np.round(length / GRID))
