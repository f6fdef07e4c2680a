"""Gives strokes more nodes where the edges that were seen lie steadily beside them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from robot.calibration.misses import Misses
from robot.geometry import Array
from robot.mapping.stroke_fitting import DENSEST
from robot.mapping.strokes import Stroke, Strokes

PARTS = 4
"""Parts into which each span between two nodes is divided."""
ENOUGH = 12
"""A part counts if at least this many edges were seen in it, from at least a third as many
pictures."""
STEADY = 0.00012
"""Mean distance from which on the edges lie beside a stroke [m]; on a straight one, twice it."""


def refined(strokes: Strokes, seen: Misses) -> Strokes:
    """Return strokes with more nodes, or the same object if none of them needs more."""
    edges = strokes.edges
    stroke, place = edges.stroke[seen.edge], edges.place(seen.edge, seen.ends)
    aside = np.where(edges.on_left[seen.edge], seen.metres, -seen.metres)
    finer = [
        _finer(traced, moved, place[some], aside[some], seen.picture[some])
        for number, (traced, moved) in enumerate(zip(strokes.traced, strokes.each, strict=True))
        for some in [stroke == number]
    ]
    if all(new is None for new in finer):
        return strokes
    return Strokes.of(
        [new or moved for new, moved in zip(finer, strokes.each, strict=True)], strokes.width
    )


def _finer(
    traced: Stroke, moved: Stroke, place: Array, aside: Array, picture: NDArray[np.int64]
) -> Stroke | None:
    knots = traced.knots
    cuts = np.concatenate([np.linspace(a, b, PARTS, endpoint=False) for a, b in pairwise(knots)])
    part = np.clip(np.searchsorted(cuts, place, side="right") - 1, 0, len(cuts) - 1)
    # Where the tape curves, a picture's edges err together: each picture counts once.
    pairs = np.unique(np.column_stack([part, picture]), axis=0)[:, 0]
    pictures = np.bincount(pairs, minlength=len(cuts))
    counts = np.bincount(part, minlength=len(cuts))
    limit = STEADY if traced.curved else 2 * STEADY
    # Half of those that are far off are of other tape.
    near = np.abs(aside) < 0.01
    means = np.bincount(part[near], aside[near], minlength=len(cuts)) / np.maximum(
        1, np.bincount(part[near], minlength=len(cuts))
    )
    beside = (counts >= ENOUGH) & (pictures >= ENOUGH // 3) & (np.abs(means) > limit)
    spans = beside.reshape(-1, PARTS).any(axis=1) & (np.diff(knots) >= 2 * DENSEST)
    if not spans.any():
        return None
    middles = (knots[:-1] + knots[1:])[spans] / 2
    if not traced.curved:
        nodes = np.vstack([moved.nodes[0], moved.nodes.mean(axis=0), moved.nodes[1]])
        return Stroke(nodes, curved=True)
    places = np.sort(np.concatenate([knots[: len(traced.nodes)], middles]))
    nodes = traced.spline(moved.nodes)(places)
    return Stroke(nodes, curved=True, closed=traced.closed)
