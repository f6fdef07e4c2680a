"""Cuts traced lines at corners of tape: ``at_corners``.

A line that was traced around an obtuse or acute corner looks round there, over some centimetres.
A spline would follow that, and no spline bends as sharply as the tape. What the adjustment cannot
explain by the strokes it explains by the robot: the whole map takes a wrong scale.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from operator import is_
from typing import NamedTuple

import numpy as np

from robot.geometry import Array
from robot.mapping.stroke_fitting import FINE_SPACING, fit_stroke
from robot.mapping.strokes import Stroke, Strokes

ROUND, SIDE = 0.025, 0.09
"""Traced lines are round this far on both sides of a corner; beyond, this much of them shows where
each side leads [m]."""
LEAST_SIDE, LEAST_POINTS = 0.045, 4
"""... if at least this length of a side was traced [m], by at least so many points."""
STRAIGHT_SIDE, ROUGH_SIDE, MOST_CURVED = 0.0008, 0.0009, 8.0
"""A side is straight if its points lie at most the first beside a line [m]. Else it is a parabola,
if their deviation from it is at most the second [m], and it curves less than the third [1/m]: what
bends more sharply is no side, but the rounding itself."""
LEAST_CORNER = math.radians(14)
"""Where tape turns by less, a spline follows it [rad]."""
LONGEST_ROUNDING = 0.024
"""Tape that needs more than this on each side to turn is bent, not cut [m]."""
ROUGHER = 2.5
"""Factor of these lengths while the path is rough."""
SAMPLES = 0.01
"""Distance of the points of a curve that may have corners [m]."""
STEP = 0.004
"""Distance of the places where a corner is looked for [m]."""


class _Side(NamedTuple):
    """Where one side of a corner leads, as a parabola over the way from its middle."""

    origin: Array
    along: Array
    curvature: float

    def at(self, way: float) -> tuple[Array, float]:
        """Return the place (2,) at a way from the middle [m], and the direction there [rad]."""
        left = np.array([-self.along[1], self.along[0]])
        place = self.origin + way * self.along + self.curvature / 2 * way**2 * left
        return place, math.atan2(*self.along[::-1]) + math.atan(self.curvature * way)


def at_corners(line: Array, closed: bool = False, *, rough: bool = False) -> list[Array]:
    """Return the pieces (n, 2) of a traced line between its corners, without their round ends [m].

    Args:
        line: (n, 2) points in order [m].
        closed: whether the last one is the first.
        rough: whether the path is, so that what was traced from it may be wrong by millimetres.
    """
    corners = _corners(line, closed, ROUGHER if rough else 1.0)
    if not corners:
        return [line]
    walked = _walked(line)
    total = walked[-1]
    if closed:
        corners.append(corners[0] + total)
        line, walked = np.vstack([line[:-1], line]), np.append(walked[:-1], walked + total)
    else:
        corners = [-math.inf, *corners, math.inf]
    return [
        line[(walked > begin + ROUND) & (walked < end - ROUND)] for begin, end in pairwise(corners)
    ]


def cut_at_corners(strokes: Strokes, *, rough: bool = False) -> Strokes:
    """Return strokes whose curves are cut at corners; the same object if none has one.

    If the path is rough, so are the strokes: see ``at_corners``.
    """
    each: list[Stroke] = []
    for stroke in strokes.each:
        curve = stroke.curved
        pieces = at_corners(_samples(stroke), stroke.closed, rough=rough) if curve else []
        if len(pieces) > 1 or (pieces and stroke.closed and not _is_whole(pieces[0])):
            fitted = (fit_stroke(piece, spacing=FINE_SPACING) for piece in pieces)
            each += [piece for piece in fitted if piece is not None]
        else:
            each.append(stroke)
    same = len(each) == len(strokes.each) and all(map(is_, each, strokes.each))
    return strokes if same else Strokes.of(each, strokes.width)


def _is_whole(line: Array) -> bool:
    return bool(np.array_equal(line[0], line[-1]))


def _samples(stroke: Stroke) -> Array:
    count = 2 + round(stroke.knots[-1] / SAMPLES)
    points = stroke.spline(stroke.nodes)(np.linspace(0.0, stroke.knots[-1], count))
    return np.asarray(points, np.float64)


def _corners(line: Array, closed: bool, tolerance: float) -> list[float]:
    """Return where the corners of a line are, as lengths along it from its first point [m].

    The tolerance is a factor of what a line may be off.
    """
    walked = _walked(line)
    total = float(walked[-1])
    reach = ROUND + SIDE
    if total < 2 * (ROUND + LEAST_SIDE):
        return []
    if closed:
        before, after = walked[:-1] > total - reach, walked[1:] < reach
        line = np.vstack([line[:-1][before], line, line[1:][after]])
        walked = np.concatenate([walked[:-1][before] - total, walked, walked[1:][after] + total])
    sides = _Sides(line, walked, tolerance)
    candidates = [
        (rounding, place)
        for place in np.arange(0.0, total, STEP)
        if (rounding := _rounding(sides, place)) < tolerance * LONGEST_ROUNDING
    ]
    return sorted(_sharpest(candidates, total if closed else math.inf))


def _sharpest(candidates: list[tuple[float, float]], total: float) -> Iterator[float]:
    """Yield the sharpest places of those that are near each other."""
    taken: list[float] = []
    for _, place in sorted(candidates):
        away = [abs(place - other) for other in taken]
        if all(min(each, total - each) > ROUND + LEAST_SIDE for each in away):
            taken.append(place)
            yield place


class _Sides:
    """Where the pieces of one line lead. Places lie closer together than its points, so most pieces
    are asked for again and again."""

    def __init__(self, line: Array, walked: Array, tolerance: float) -> None:
        self.line, self.walked, self._tolerance = line, walked, tolerance
        self._known: dict[tuple[int, int], _Side | None] = {}

    def beside(self, away: Array) -> _Side | None:
        """Return the side of the points that are far enough from a place, by their way (n,) [m]."""
        chosen = np.flatnonzero((away > ROUND) & (away < ROUND + SIDE))
        if len(chosen) < LEAST_POINTS:
            return None
        key = int(chosen[0]), int(chosen[-1])
        if key not in self._known:
            self._known[key] = _side(self.line[chosen], self._tolerance)
        return self._known[key]


def _rounding(sides: _Sides, place: float) -> float:
    """Return over which length before and behind a place a line turns [m]; inf if it is smooth."""
    line, walked = sides.line, sides.walked
    before, after = sides.beside(place - walked), sides.beside(walked - place)
    if before is None or after is None:
        return math.inf
    point = _between(line, walked, place)
    ways = [float((point - side.origin) @ side.along) for side in (before, after)]
    (start, direction), (end, other) = before.at(ways[0]), after.at(ways[1])
    turn = abs(math.remainder(other - direction, math.tau))
    if turn < LEAST_CORNER:
        return math.inf
    # The tip is where both sides would meet, and the line cuts it off.
    sine = math.sin(other - direction)
    if abs(sine) < math.sin(LEAST_CORNER) / 2:
        return math.inf
    away = end - start
    further = (away[0] * math.sin(other) - away[1] * math.cos(other)) / sine
    tip = start + further * np.array([math.cos(direction), math.sin(direction)])
    return math.dist(tip, point) / math.tan(turn / 4)


def _side(points: Array, tolerance: float) -> _Side | None:
    """Return where points (n, 2) lead; None if they are too few, or bend themselves."""
    if len(points) < LEAST_POINTS or math.dist(points[0], points[-1]) < LEAST_SIDE:
        return None
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=False)
    along = axes[0] * (np.sign((points[-1] - points[0]) @ axes[0]) or 1.0)
    away = points - middle
    way, aside = away @ along, away[:, 1] * along[0] - away[:, 0] * along[1]
    if np.abs(aside).max() <= tolerance * STRAIGHT_SIDE:
        return _Side(middle, along, 0.0)
    square, slope, offset = np.polyfit(way, aside, 2)
    rough = np.std(aside - np.polyval((square, slope, offset), way))
    if rough > tolerance * ROUGH_SIDE or abs(2.0 * square) > MOST_CURVED:
        return None
    left = np.array([-along[1], along[0]])
    turned = along + slope * left
    return _Side(middle + offset * left, turned / math.hypot(*turned), 2.0 * float(square))


def _between(line: Array, walked: Array, place: float) -> Array:
    """Return the point (2,) of a line at a length from its first point [m]."""
    return np.array([np.interp(place, walked, column) for column in line.T])


def _walked(line: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
