"""The floor's grid as a camera sees it: by it one sees whether a mounting is right."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from robot.camera import FloorView
from robot.geometry import Array

APART = 0.1
"""Distance of the grid's lines [m]."""
REACH = 1.0
"""How far ahead, and to either side, the grid reaches [m]."""
STEP = 0.005
"""Distance of the points along a line, which the lens bends [m]."""
MARGIN = -20.0
"""Lines end this far outside of the picture [px]."""
LABEL_MARGIN = 12.0
"""Distances stand at least this far inside of it [px]."""


@dataclass(frozen=True, slots=True, eq=False)
class GridLine:
    """A part of a line that the picture shows."""

    pixels: Array = field(repr=False)
    """(n, 2) along it [px]."""
    ahead: bool
    """Whether it is the line straight ahead of the robot."""


def grid_lines(view: FloorView) -> Iterator[GridLine]:
    """Yield the lines of the grid that the picture shows, every 0.1 m ahead and to either side."""
    steps = round(REACH / STEP)
    marks = np.arange(0, REACH + APART / 2, APART)
    along, aside = np.linspace(0, REACH, steps + 1), np.linspace(-REACH, REACH, 2 * steps + 1)
    for mark in marks:
        for side in {mark, -mark}:
            points = np.column_stack([along, np.full(len(along), side)])
            yield from _shown(view, points, ahead=side == 0)
        points = np.column_stack([np.full(len(aside), mark), aside])
        yield from _shown(view, points, ahead=False)


def grid_labels(view: FloorView) -> list[tuple[float, Array]]:
    """Return the distances ahead of the axle [m] that the picture shows, and their pixels (2,)."""
    marks = np.arange(0, REACH + APART / 2, APART)
    pixels = view.pixels(np.column_stack([marks, np.zeros(len(marks))]))
    seen = view.inside(pixels, LABEL_MARGIN)
    return list(zip(marks[seen].tolist(), pixels[seen], strict=True))


def _shown(view: FloorView, points: Array, *, ahead: bool) -> Iterator[GridLine]:
    """Yield each part of a line of floor points (n, 2) that lies in the picture."""
    pixels = view.pixels(points)
    seen = np.concatenate([[False], view.inside(pixels, MARGIN), [False]])
    ends = np.flatnonzero(np.diff(seen.astype(int))).reshape(-1, 2)
    for first, last in ends.tolist():
        if last - first > 1:
            yield GridLine(pixels[first:last], ahead)
