"""Cuts strokes where rays saw bare floor, as between dashes of tape."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from operator import is_

import numpy as np

from robot.mapping.bare_floor import gaps
from robot.mapping.crossings import Crossings, crossings
from robot.mapping.ends import RaysOnFloor
from robot.mapping.stroke_fitting import DENSEST
from robot.mapping.strokes import Stroke, Strokes

SHORTEST_PIECE = 0.03
"""Shorter pieces between gaps are none [m]."""


def without_gaps(strokes: Strokes, rays: RaysOnFloor) -> Strokes:
    """Return strokes that are cut where there is none of their tape; the same object if nowhere."""
    pieces = [
        piece
        for stroke in strokes.each
        for piece in pieces_of(stroke, crossings(stroke, strokes.width, rays))
    ]
    same = len(pieces) == len(strokes.each) and all(map(is_, pieces, strokes.each))
    return strokes if same else Strokes.of(pieces, strokes.width)


def pieces_of(stroke: Stroke, crossed: Crossings) -> Iterator[Stroke]:
    """Yield the pieces of a stroke; the same object if there is no gap."""
    total = float(stroke.knots[-1])
    bare = list(gaps(crossed.tape, crossed.bare, 0.0, total))
    if not bare:
        yield stroke
        return
    begins = [0.0, *(end for _, end in bare)]
    ends = [*(begin for begin, _ in bare), total]
    spans = list(zip(begins, ends, strict=True))
    if stroke.closed:
        # The last piece goes on over the first node.
        spans = [*spans[1:-1], (spans[-1][0], total + spans[0][1])]
    for begin, end in spans:
        if end - begin >= SHORTEST_PIECE:
            yield _part(stroke, begin, end)


def _part(stroke: Stroke, begin: float, end: float) -> Stroke:
    """Return a stroke from one place to another, as sums of chords [m]."""
    if not stroke.curved:
        first, last = stroke.nodes
        shares = np.array([[begin], [end]]) / stroke.knots[-1]
        return replace(stroke, nodes=first + shares * (last - first))
    total = float(stroke.knots[-1])
    places = np.linspace(begin, end, max(4, 1 + round((end - begin) / DENSEST)))
    spline = stroke.spline(stroke.nodes)
    nodes = spline(np.mod(places, total) if stroke.closed else places)
    return Stroke(np.asarray(nodes, np.float64), curved=True)
