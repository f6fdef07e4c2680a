"""Finds strokes whose edges are those of other strokes: in corners, where tape looks odd."""

from __future__ import annotations

import numpy as np

from robot.calibration.misses import Misses
from robot.fields.drawing.curves import distances
from robot.geometry import Array
from robot.mapping.strokes import Stroke, Strokes

SHORT = 0.3
"""Longer strokes are not looked at [m]."""
LED_ON = 0.1
"""Tape may go on this far beyond the end of its stroke [m]."""
CLOSE = 0.006
"""An edge this near to that of another stroke may be of it [m]."""
LEAST_OWN = 0.3
"""Share of a stroke's edges that have to be its own."""


def without_redundant(strokes: Strokes, seen: Misses) -> list[Stroke]:
    """Return those strokes that explain edges which no other one explains.

    Args:
        strokes: as they were adjusted.
        seen: the edges, and to which of the strokes' edges each belongs.
    """
    kept, of_edge = list(strokes.each), strokes.edges.stroke
    short = [k for k, stroke in enumerate(strokes.each) if stroke.length < SHORT]
    for number in sorted(short, key=lambda k: strokes.each[k].length):
        stroke = strokes.each[number]
        points = seen.ends[of_edge[seen.edge] == number]
        others = [
            other if other.closed else other.with_end(False, LED_ON).with_end(True, LED_ON)
            for other in kept
            if other is not stroke
        ]
        if not others or not len(points):
            continue
        distance = _from_edges(points, Strokes.of(others, strokes.width).edges.edges)
        if np.mean(distance > CLOSE) < LEAST_OWN:
            kept = [other for other in kept if other is not stroke]
    return kept


def _from_edges(points: Array, edges: Array) -> Array:
    nearest = np.full(len(points), np.inf)
    for edge in edges:
        nearest = np.minimum(nearest, distances(points, edge[:2], edge[2:]))
    return nearest
