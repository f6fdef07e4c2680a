"""Marks inside a generated field: crosses, lines, bars, stubs, dashes, bends and islands."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import shapely

from robot.fields.generator.strokes import BEND, TapeLine, bent, oval, straight_parts

SHORTEST = 150
"""Shortest line of tape [mm]."""

Draw = Callable[[np.random.Generator, shapely.Geometry], list[TapeLine]]
"""Draws a mark, from a random generator and the enclosed area [mm]."""


def cross(rng: np.random.Generator, area: shapely.Geometry) -> list[TapeLine]:
    """Draw two lines from side to side."""
    return across(rng, area, 0.0) + across(rng, area, math.pi / 2)


def line(rng: np.random.Generator, area: shapely.Geometry) -> list[TapeLine]:
    """Draw one line from side to side, along an axis or at a slant."""
    turn = rng.choice([0.0, math.pi / 2, rng.uniform(0.3, 1.2), -rng.uniform(0.3, 1.2)])
    return across(rng, area, float(turn))


def bar(rng: np.random.Generator, area: shapely.Geometry) -> list[TapeLine]:
    """Draw a line whose ends are free."""
    middle = np.array(_place(rng, area, 150))
    turn = float(rng.choice([0.0, math.pi / 2, rng.uniform(-math.pi, math.pi)]))
    half = rng.uniform(100, 250)
    reach = half * np.array([math.cos(turn), math.sin(turn)])
    ends = shapely.LineString([middle - reach, middle + reach])
    return straight_parts(shapely.intersection(ends, shapely.buffer(area, -120)), SHORTEST)


def stub(rng: np.random.Generator, area: shapely.Geometry) -> list[TapeLine]:
    """Draw a line from a side inward."""
    ring = shapely.LineString(shapely.get_coordinates(area))
    position = rng.uniform(0, ring.length)
    before, foot, after = (ring.interpolate((position + s) % ring.length) for s in (-5, 0, 5))
    dx, dy = after.x - before.x, after.y - before.y
    across_side = np.array([-dy, dx]) / max(math.hypot(dx, dy), 1e-9)
    start = np.array([foot.x, foot.y])
    if not shapely.contains_xy(area, *(start + 60 * across_side)):
        across_side = -across_side
    end = start + rng.uniform(SHORTEST + 50, 375) * across_side
    return [bent([(start[0], start[1]), (end[0], end[1])])]


def dashes(rng: np.random.Generator, area: shapely.Geometry) -> list[TapeLine]:
    """Draw a dashed line from side to side."""
    turn = float(rng.choice([0.0, math.pi / 2]))
    dash, gap = rng.integers(8, 16) * 10, rng.integers(6, 12) * 10
    return [
        TapeLine(item.path, item.line, f"{dash} {gap}") for item in across(rng, area, turn)
    ]  # fmt: skip


def bends(rng: np.random.Generator, area: shapely.Geometry) -> list[TapeLine]:
    """Draw an S of bent tape whose ends are free."""
    xmin, ymin, xmax, ymax = shapely.bounds(shapely.buffer(area, -130)).tolist()
    long = xmax - xmin
    low = rng.uniform(ymin, (ymin + ymax) / 2)
    high = rng.uniform((low + ymax) / 2, ymax)
    first, last = np.sort(rng.uniform(xmin + 0.25 * long, xmax - 0.25 * long, 2))
    corners = [(xmin, low), (first, low), (last, high), (xmax, high)]
    if rng.random() < 0.5:
        corners = [(-x, y) for x, y in corners]
    item = bent(corners, float(rng.integers(BEND, 300)))
    return [item] if shapely.buffer(area, -100).covers(item.line) else []


def island(rng: np.random.Generator, area: shapely.Geometry) -> list[TapeLine]:
    """Draw a small closed shape."""
    half = float(rng.integers(BEND, 210))
    x, y = (float(np.round(item)) for item in _place(rng, area, half + 120))
    if rng.random() < 0.5:
        each = oval(x, y, half, half)
    else:
        other = float(rng.integers(BEND, 210))
        corners = [(x - half, y - other), (x + half, y - other), (x + half, y + other)]
        each = bent([*corners, (x - half, y + other)], closed=True)
    return [each] if shapely.buffer(area, -100).covers(each.line) else []


MARKS: tuple[tuple[Draw, float], ...] = (
    (cross, 0.12),
    (line, 0.15),
    (bar, 0.15),
    (stub, 0.24),
    (dashes, 0.1),
    (bends, 0.12),
    (island, 0.12),
)
"""The marks, each with its probability."""


def across(rng: np.random.Generator, area: shapely.Geometry, turn: float) -> list[TapeLine]:
    """Draw a straight line at an angle [rad], from side to side through a point of the area."""
    middle = np.array(_place(rng, area, 150))
    way = 5000 * np.array([math.cos(turn), math.sin(turn)])
    whole = shapely.LineString([middle - way, middle + way])
    return straight_parts(shapely.intersection(whole, area), SHORTEST)


def _place(rng: np.random.Generator, area: shapely.Geometry, margin: float) -> tuple[float, float]:
    """Draw a point of an area, if possible on a grid of 25 mm and this far from the border [mm]."""
    inner = shapely.buffer(area, -margin)
    if inner.is_empty:
        middle = shapely.point_on_surface(area)
        return middle.x, middle.y
    low, high = np.reshape(shapely.bounds(inner), (2, 2))
    for _ in range(100):
        x, y = (25 * np.round(rng.uniform(low, high) / 25)).tolist()
        if inner.covers(shapely.Point(x, y)):
            return x, y
    middle = shapely.point_on_surface(inner)
    return middle.x, middle.y
