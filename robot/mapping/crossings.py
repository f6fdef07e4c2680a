"""Counts what rays saw that cross a stroke: its tape, or bare floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from robot.geometry import Array
from robot.mapping.ends import ON_EDGE, STEEP, RaysOnFloor
from robot.mapping.strokes import Stroke

BARE_BEYOND = 0.02
"""A ray that goes on this far beyond tape without meeting anything saw bare floor there [m]."""
MOST_BARE = 0.02
"""Largest share of all rays across tape that may see bare floor; a right map has a tenth of it."""
BARE_STROKE = 0.2
"""A stroke is contradicted by a larger share than this."""


class Crossings(NamedTuple):
    """Where rays crossed a stroke, as sums of chords (``Stroke.knots``) [m]."""

    tape: Array
    """(n,) where they saw its tape."""
    bare: Array
    """(m,) where they saw bare floor."""


@dataclass(frozen=True, eq=False)
class BareFloor:
    """How often bare floor was seen where a map has tape."""

    share: float
    """Of all rays that cross tape of the map."""
    places: Array
    """(n, 2) middles of the strokes that were contradicted most [m]."""

    @property
    def contradicts(self) -> bool:
        """Whether the map is wrong: its path was lost, or a stroke is not there."""
        return self.is_lost or len(self.places) > 0

    @property
    def is_lost(self) -> bool:
        """Whether enough rays contradict it to show that tape was drawn twice, or the path was
        lost."""
        return self.share > MOST_BARE

    @classmethod
    def of(cls, strokes: Sequence[Stroke], width: float, rays: RaysOnFloor) -> BareFloor:
        """Return what the rays of a drive saw of a map with tape of a width [m]."""
        crossed = [crossings(stroke, width, rays) for stroke in strokes]
        counts = np.array([[len(places) for places in each] for each in crossed]).reshape(-1, 2)
        shares = counts[:, 1] / np.maximum(1, counts.sum(axis=1))
        places = [
            stroke.points[len(stroke.points) // 2 - 1 : len(stroke.points) // 2 + 1].mean(axis=0)
            for stroke, share in zip(strokes, shares, strict=True)
            if share > BARE_STROKE
        ]
        share = counts[:, 1].sum() / max(1, counts.sum())
        return cls(float(share), np.array(places).reshape(-1, 2))


def crossings(stroke: Stroke, width: float, rays: RaysOnFloor) -> Crossings:
    """Return what the rays saw that cross a stroke of a width [m]."""
    points, places = stroke.points, stroke.places
    tape, bare = [np.zeros(0)], [np.zeros(0)]
    way = rays.end - rays.begin
    length = np.hypot(*way.T)
    entry = np.hypot(*(rays.entry - rays.begin).T)
    first = np.hypot(*(rays.first - rays.begin).T)
    with np.errstate(invalid="ignore", divide="ignore"):
        for k, (start, step) in enumerate(zip(points[:-1], np.diff(points, axis=0), strict=True)):
            left = np.array([-step[1], step[0]]) / math.hypot(*step)
            sine = way @ left / length
            reached = ((start - rays.begin) @ left) / (way @ left)
            place = ((rays.begin - start) + reached[:, None] * way) @ step / (step @ step)
            crosses = (reached > 0) & (reached < 1) & (place >= 0) & (place < 1)
            crosses &= np.abs(sine) > STEEP
            half = width / 2 / np.abs(sine)
            crossing = reached * length
            along = places[k] + place * (places[k + 1] - places[k])
            tape.append(along[crosses & (np.abs(crossing - half - entry) < ON_EDGE)])
            beyond = np.isnan(first) | (first > crossing + half + BARE_BEYOND)
            bare.append(along[crosses & beyond])
    return Crossings(np.concatenate(tape), np.concatenate(bare))


def is_tape(stroke: Stroke, width: float, rays: RaysOnFloor) -> bool:
    """Return whether more rays that cross a stroke of a width [m] saw tape there than bare floor.

    Clutter in a corner, or two pieces of tape side by side, may look like tape from one place.
    """
    tape, bare = crossings(stroke, width, rays)
    return len(tape) >= len(bare)
