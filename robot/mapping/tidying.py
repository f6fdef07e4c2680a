"""Lets strokes end where the tape does: in corners, at other strokes, or freely.

Strokes end before all of these, as nobody measures there. They are led on to another stroke only if
no ray saw bare floor in between.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from robot.mapping.ends import End, RaysOnFloor, find_end
from robot.mapping.joining import SLACK, EndName, end_names
from robot.mapping.stroke_fitting import SHORTEST
from robot.mapping.strokes import Stroke, Strokes

SNAP, MEETING, BACK = 0.09, 0.08, 0.05
"""A stroke is led on to a corner, or to another stroke, that is nearer than this to where tape was
seen, or cut there [m]."""
CROSSING = math.sin(math.radians(15))
"""Strokes at a smaller angle do not meet."""
SHARPEST = math.cos(math.radians(30))
"""Cosine of the least angle inside a corner: two ends that lead on nearly side by side are of one
piece of tape that was traced twice."""


@dataclass(frozen=True)
class TidyStrokes:
    """Strokes that end where the tape does."""

    strokes: tuple[Stroke, ...]
    corners: tuple[tuple[EndName, EndName], ...]
    """Pairs of ends that meet in a corner."""
    ends: dict[EndName, End]
    """What was seen of the free ends, and those that nobody saw."""


def tidied(strokes: Strokes, rays: RaysOnFloor) -> TidyStrokes:
    """Return strokes that end where the tape does: in corners, at other strokes, or freely."""
    each = list(strokes.each)
    half = strokes.width / 2
    ends = {name: find_end(each[name[0]], name[1], strokes.width, rays) for name in end_names(each)}
    further: dict[EndName, float] = {}
    corners = []
    for _, a, b, to_a, to_b in sorted(_corners(ends, half), key=lambda item: item[0]):
        if a not in further and b not in further:
            further[a], further[b] = to_a, to_b
            corners.append((a, b))
    for name, end in ends.items():
        if name in further:
            continue
        meeting = _meeting(end, [s for k, s in enumerate(each) if k != name[0]], half)
        further[name] = end.length if meeting is None else meeting
    free = {name: end for name, end in ends.items() if further[name] == end.length}
    for (number, last), length in further.items():
        each[number] = each[number].with_end(last, length)
    # Short pieces that other strokes cover are of places where tape looks odd.
    in_corners = {number for pair in corners for number, _ in pair}
    kept = [k for k, s in enumerate(each) if k in in_corners or s.length > SHORTEST]
    return TidyStrokes(tuple(each[k] for k in kept), *renumbered(kept, corners, free))


def renumbered(
    kept: Sequence[int], corners: Sequence[tuple[EndName, EndName]], ends: dict[EndName, End]
) -> tuple[tuple[tuple[EndName, EndName], ...], dict[EndName, End]]:
    """Return corners and ends of those strokes that are kept, by their new numbers."""
    number_of = {old: new for new, old in enumerate(kept)}
    left = tuple(
        ((number_of[a], i), (number_of[b], j))
        for (a, i), (b, j) in corners
        if a in number_of and b in number_of
    )
    return left, {(number_of[k], last): end for (k, last), end in ends.items() if k in number_of}


def _corners(
    ends: dict[EndName, End], half: float
) -> Iterator[tuple[float, EndName, EndName, float, float]]:
    """Yield the corners that two ends may meet in: their sizes, the ends, and how far to go."""
    for a, b in combinations(ends, 2):
        if a[0] == b[0]:
            continue
        end, other = ends[a], ends[b]
        sine = end.outward[0] * other.outward[1] - end.outward[1] * other.outward[0]
        if abs(sine) < CROSSING or end.outward @ other.outward > SHARPEST:
            continue
        away = other.place - end.place
        to_a = (away[0] * other.outward[1] - away[1] * other.outward[0]) / sine
        to_b = (away[0] * end.outward[1] - away[1] * end.outward[0]) / sine
        reach = half / abs(sine) + SLACK
        if _is_reached(end, to_a, reach, SNAP) and _is_reached(other, to_b, reach, SNAP):
            yield abs(to_a) + abs(to_b), a, b, float(to_a), float(to_b)


def _is_reached(end: End, length: float, reach: float, farthest: float) -> bool:
    """Return whether tape may go on for a length, up to where other tape hides it."""
    farthest = max(0.0, end.lower) + min(farthest, end.ahead)
    return -BACK < length < farthest and end.upper > length - reach


def _meeting(end: End, others: Sequence[Stroke], half: float) -> float | None:
    """Return how far it is to another stroke [m]; None if none is met."""
    nearest = None
    for stroke in others:
        points = stroke.points
        way = np.diff(points, axis=0)
        away = points[:-1] - end.place
        with np.errstate(invalid="ignore", divide="ignore"):
            sine = end.outward[0] * way[:, 1] - end.outward[1] * way[:, 0]
            length = (away[:, 0] * way[:, 1] - away[:, 1] * way[:, 0]) / sine
            part = (away[:, 0] * end.outward[1] - away[:, 1] * end.outward[0]) / sine
            sines = np.abs(sine) / np.hypot(*way.T)
        for k in np.flatnonzero((part >= 0) & (part <= 1) & (sines > CROSSING)):
            if _is_reached(end, length[k], half / sines[k] + SLACK, MEETING) and (
                nearest is None or abs(length[k]) < abs(nearest)
            ):
                nearest = float(length[k])
    return nearest
