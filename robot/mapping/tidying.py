"""Joins strokes that are one piece of tape, and lets them end where the tape does.

Strokes end before corners, crossings and the ends of tape, as nobody measures there. They are
joined, or led on to another stroke, only if no ray saw bare floor in between.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from robot.geometry import Array
from robot.mapping.ends import End, RaysOnFloor, find_end
from robot.mapping.stroke_fitting import DENSEST, SHORTEST, fit_stroke
from robot.mapping.stroke_fitting import SPACING as NODES
from robot.mapping.strokes import Stroke, Strokes

GAP, UNSEEN_GAP = 0.40, 0.12
"""Strokes that continue each other are one if they are nearer than this [m]: if rays saw the tape
in between, or not."""
OVERLAPPING = 0.4
"""... or overlap by less than this [m]."""
SMALLEST_RING = 0.6
"""A stroke's own ends are joined if it is longer than this [m]."""
TURN, TURN_BY_GAP = math.radians(10), math.radians(200)
"""... and if their directions differ by less than this [rad], and by the gap, as tape may bend
there [rad/m]."""
ASIDE, ASIDE_SHARE = 0.004, 0.08
"""... and if one lies less beside the other [m], and as a share of the gap."""
SNAP, MEETING, BACK = 0.09, 0.08, 0.05
"""A stroke is led on to a corner, or to another stroke, that is nearer than this to where tape was
seen, or cut there [m]."""
CROSSING = math.sin(math.radians(15))
"""Strokes at a smaller angle do not meet."""
SLACK = 0.006
"""Bare floor begins so much farther than it seems, at most [m]."""
SPACING = 0.02
"""Distance of the points of two strokes that are joined to one [m]."""

EndName = tuple[int, bool]
"""A stroke's number, and whether it is the last end of it."""


@dataclass(frozen=True)
class TidyStrokes:
    """Strokes that end where the tape does."""

    strokes: tuple[Stroke, ...]
    corners: tuple[tuple[EndName, EndName], ...]
    """Pairs of ends that meet in a corner."""
    ends: dict[EndName, End]
    """What was seen of the free ends, and those that nobody saw."""


def joined(strokes: Strokes, rays: RaysOnFloor) -> Strokes:
    """Return strokes of which those are one that continue each other; the same object if none."""
    each = list(strokes.each)
    changed = False
    while (pair := _next_pair(each, strokes.width, rays)) is not None:
        (a, a_last), (b, b_last) = pair
        changed = True
        if a == b:
            each[a] = _closed(each[a])
            continue
        before = each[a] if a_last else each[a].reversed
        after = each[b].reversed if b_last else each[b]
        whole = join(before, after)
        each = [stroke for k, stroke in enumerate(each) if k not in (a, b)] + [whole]
    return Strokes.of(each, strokes.width) if changed else strokes


def _names(strokes: Sequence[Stroke]) -> Iterator[EndName]:
    for number, stroke in enumerate(strokes):
        if not stroke.closed:
            yield number, False
            yield number, True


def _next_pair(
    strokes: Sequence[Stroke], width: float, rays: RaysOnFloor
) -> tuple[EndName, EndName] | None:
    """Return the two nearest ends that continue each other."""
    ends = {name: strokes[name[0]].end(name[1]) for name in _names(strokes)}
    pairs = []
    for a, b in combinations(ends, 2):
        (place, outward), (other_place, backward) = ends[a], ends[b]
        away = other_place - place
        gap = float(away @ outward)
        aside = abs(float(away[0] * outward[1] - away[1] * outward[0]))
        turn = math.acos(np.clip(-outward @ backward, -1.0, 1.0))
        if a[0] == b[0] and strokes[a[0]].length < SMALLEST_RING:
            continue
        if (
            -OVERLAPPING < gap < GAP
            and turn < TURN + TURN_BY_GAP * max(0.0, gap)
            and aside < ASIDE + max(0.0, gap) * (ASIDE_SHARE + math.sin(turn / 2))
        ):
            pairs.append((abs(gap), a, b))
    for gap, a, b in sorted(pairs):
        seen = [find_end(strokes[number], last, width, rays) for number, last in (a, b)]
        bare = min(end.upper for end in seen)
        if bare < gap - SLACK:
            continue
        if gap < UNSEEN_GAP or sum(max(0.0, end.lower) for end in seen) > gap - 0.02:
            return a, b
    return None


def join(before: Stroke, after: Stroke) -> Stroke:
    """Return one stroke along two, of which the second continues the first."""
    if not before.curved and not after.curved:
        whole = fit_stroke(np.vstack([_short_of(after, _samples(before), before), _samples(after)]))
        return after if whole is None else whole
    # A curve keeps its nodes: they were adjusted where they are.
    second = _nodes(after)
    first = _short_of(after, _nodes(before), before)
    first = first[np.hypot(*(first - second[0]).T) > DENSEST / 2]
    return Stroke(np.vstack([first, second]), curved=True)


def _short_of(after: Stroke, points: Array, before: Stroke) -> Array:
    """Return those points (n, 2) along a stroke that come before another one, which overlaps it."""
    forward = (points - after.nodes[0]) @ before.end(True)[1]
    # Farther back the tape may bend around.
    kept = np.flatnonzero(forward < 0)
    return points[: kept[-1] + 1] if len(kept) else points[:0]


def _nodes(stroke: Stroke) -> Array:
    """Return nodes (n, 2) of a spline along a stroke."""
    if stroke.curved:
        return stroke.nodes
    start, end = stroke.nodes
    shares = np.linspace(0, 1, 2 + round(stroke.length / NODES))[:, None]
    return np.asarray(start + shares * (end - start), np.float64)


def _closed(stroke: Stroke) -> Stroke:
    points = _samples(stroke)
    closed = fit_stroke(np.vstack([points, points[:1]]), closed=True)
    assert closed is not None
    return closed


def _samples(stroke: Stroke) -> Array:
    places = np.linspace(0, stroke.knots[-1], 2 + round(stroke.knots[-1] / SPACING))
    if stroke.curved:
        return np.asarray(stroke.spline(stroke.nodes)(places), np.float64)
    start, end = stroke.nodes
    return np.asarray(start + places[:, None] / stroke.knots[-1] * (end - start), np.float64)


def tidied(strokes: Strokes, rays: RaysOnFloor) -> TidyStrokes:
    """Return strokes that end where the tape does: in corners, at other strokes, or freely."""
    each = list(strokes.each)
    half = strokes.width / 2
    ends = {name: find_end(each[name[0]], name[1], strokes.width, rays) for name in _names(each)}
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
        if abs(sine) < CROSSING:
            continue
        away = other.place - end.place
        to_a = (away[0] * other.outward[1] - away[1] * other.outward[0]) / sine
        to_b = (away[0] * end.outward[1] - away[1] * end.outward[0]) / sine
        reach = half / abs(sine) + SLACK
        if _is_reached(end, to_a, reach, SNAP) and _is_reached(other, to_b, reach, SNAP):
            yield abs(to_a) + abs(to_b), a, b, float(to_a), float(to_b)


def _is_reached(end: End, length: float, reach: float, farthest: float) -> bool:
    """Return whether tape may go on for a length, up to where other tape hides it."""
    return -BACK < length < max(0.0, end.lower) + farthest and end.upper > length - reach


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
