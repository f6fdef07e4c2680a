"""Joins strokes that are one piece of tape.

Strokes end before corners, crossings and where nobody measures. Those that continue each other are
one, if no ray saw bare floor where the tape would lie in between.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from robot.geometry import Array
from robot.mapping.bare_floor import gaps
from robot.mapping.crossings import crossings
from robot.mapping.ends import RaysOnFloor, find_end
from robot.mapping.stroke_fitting import DENSEST, fit_stroke
from robot.mapping.stroke_fitting import SPACING as NODES
from robot.mapping.strokes import Stroke, Strokes

GAP, UNSEEN_GAP = 0.40, 0.12
"""Strokes that continue each other are one if they are nearer than the first [m]. Rays have to see
the tape in between, except for at most the second [m]."""
OVERLAPPING = 0.4
"""... or overlap by less than this [m]."""
SMALLEST_RING = 0.6
"""A stroke's own ends are joined if it is longer than this [m]."""
TURN, TURN_BY_GAP, BEND = math.radians(10), math.radians(200), math.radians(400)
"""... and if their directions differ by less than the first [rad]. As tape may bend in a gap, the
limit grows with it by the second [rad/m], or by the third if one of the strokes bends."""
ASIDE, ASIDE_SHARE = 0.004, 0.08
"""... and if one lies less than this beside the other [m], and less than this share of the gap."""
SLACK = 0.006
"""Bare floor begins at most this much farther than it seems [m]."""
SPACING = 0.02
"""Distance of points along two strokes that are joined to one [m]."""
BRIDGE = 9
"""Number of nodes of a bridge between two strokes."""

EndName = tuple[int, bool]
"""A stroke's number, and whether it is the last end of it."""


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


def end_names(strokes: Sequence[Stroke]) -> Iterator[EndName]:
    """Yield the ends of all strokes that have some."""
    for number, stroke in enumerate(strokes):
        if not stroke.closed:
            yield number, False
            yield number, True


def _next_pair(
    strokes: Sequence[Stroke], width: float, rays: RaysOnFloor
) -> tuple[EndName, EndName] | None:
    """Return the two nearest ends that continue each other."""
    ends = {name: strokes[name[0]].end(name[1]) for name in end_names(strokes)}
    pairs = []
    for a, b in combinations(ends, 2):
        bends = strokes[a[0]].curved or strokes[b[0]].curved
        gap = _gap(*ends[a], *ends[b], bends=bends)
        if gap is None or (a[0] == b[0] and strokes[a[0]].length < SMALLEST_RING):
            continue
        pairs.append((abs(gap), gap, a, b))
    for _, gap, a, b in sorted(pairs):
        if gap > SLACK:
            is_one = is_tape_between(*ends[a], *ends[b], width, rays)
        else:
            seen = [find_end(strokes[number], last, width, rays) for number, last in (a, b)]
            is_one = min(end.upper for end in seen) >= gap - SLACK
        if is_one:
            return a, b
    return None


def _gap(
    place: Array, outward: Array, other_place: Array, backward: Array, *, bends: bool
) -> float | None:
    """Return how far ahead of an end another one lies that continues it [m]; None if it does not.

    Args:
        place: (2,) of the end [m].
        outward: (2,) its direction.
        other_place: (2,) of the other end [m].
        backward: (2,) its direction.
        bends: whether one of the strokes bends.
    """
    away = other_place - place
    gap = float(away @ outward)
    aside = abs(float(away[0] * outward[1] - away[1] * outward[0]))
    turn = math.acos(np.clip(-outward @ backward, -1.0, 1.0))
    length = max(0.0, gap)
    most_turn = min(TURN + (BEND if bends else TURN_BY_GAP) * length, math.pi / 2)
    follows = (
        -OVERLAPPING < gap < GAP
        and turn < most_turn
        and aside < ASIDE + length * (ASIDE_SHARE + math.tan(turn / 2))
    )
    return gap if follows else None


def is_tape_between(
    place: Array,
    outward: Array,
    other_place: Array,
    backward: Array,
    width: float,
    rays: RaysOnFloor,
) -> bool:
    """Return whether tape may lead from one end to another: rays saw it, and no bare floor.

    Args:
        place: (2,) of an end [m].
        outward: (2,) its direction.
        other_place: (2,) of the other end [m].
        backward: (2,) its direction.
        width: of the tape [m].
        rays: of the drive.
    """
    from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415 - as in strokes.py

    far = math.dist(place, other_place)
    curve = CubicHermiteSpline(
        [0.0, far], np.vstack([place, other_place]), np.vstack([outward, -backward])
    )
    bridge = Stroke(np.asarray(curve(np.linspace(0.0, far, BRIDGE)), np.float64), curved=True)
    seen, length = crossings(bridge, width, rays), float(bridge.knots[-1])
    if any(True for _ in gaps(seen.tape, seen.bare, 0.0, length)):
        return False
    places = np.concatenate([[0.0], np.sort(seen.tape), [length]])
    return bool(np.diff(places).max() < UNSEEN_GAP)


def join(before: Stroke, after: Stroke) -> Stroke:
    """Return one stroke along two, of which the second continues the first."""
    return replace(_along_both(before, after), light=before.light)


def _along_both(before: Stroke, after: Stroke) -> Stroke:
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
