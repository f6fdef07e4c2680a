"""Compiled loops of looking around: how points, outlines and rays meet a field, at many places.

Each takes a field as ``cells`` (h, w), the distance of each cell to what is dark [m], and as
``frame``: x and y of their lower left corner, their side, and the distance that counts beyond [m].
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array

Cells = NDArray[np.float32]


@compiled()
def _distance(cells: Cells, frame: Array, x: float, y: float) -> float:
    column = int(math.floor((x - frame[0]) / frame[2]))
    row = int(math.floor((y - frame[1]) / frame[2]))
    if row < 0 or column < 0 or row >= cells.shape[0] or column >= cells.shape[1]:
        return float(frame[3])
    return float(cells[row, column])


@compiled(inline="always")
def _distance_at(
    cells: Cells, frame: Array, place: tuple[float, float, float, float], x: float, y: float
) -> float:
    """Return the distance [m] at a point in the frame of a place: x, y, cosine and sine."""
    left, bottom, cos, sin = place
    return _distance(cells, frame, left + cos * x - sin * y, bottom + sin * x + cos * y)


@compiled()
def scores(
    places: Array, hits: Array, clear: Array, cells: Cells, frame: Array, costs: Array
) -> Array:
    """Return the logarithm of how well places (n, 3) agree with what was seen (n,).

    Args:
        places: where the robot may be.
        hits: (k, 2) points on tape [m], in the robot's frame.
        clear: (c, 2) points on free floor [m], in the same.
        cells: distances to tape.
        frame: of the cells.
        costs: standard deviation of a hit [m], what a hit costs at most, what tape costs where
            free floor was seen.
    """
    result = np.zeros(len(places))
    inverse = 0.5 / (costs[0] * costs[0])
    for place in range(len(places)):
        x, y, theta = places[place, 0], places[place, 1], places[place, 2]
        transform = x, y, math.cos(theta), math.sin(theta)
        total = 0.0
        for k in range(len(hits)):
            away = _distance_at(cells, frame, transform, hits[k, 0], hits[k, 1])
            total += min(away * away * inverse, costs[1])
        for k in range(len(clear)):
            if _distance_at(cells, frame, transform, clear[k, 0], clear[k, 1]) <= 0.0:
                total += costs[2]
        result[place] = -total
    return result


@compiled()
def rooms(places: Array, points: Array, cells: Cells, frame: Array) -> Array:
    """Return the smallest distance (n,) [m] of points (k, 2) in the frame of places (n, 3)."""
    result = np.full(len(places), np.inf)
    for place in range(len(places)):
        x, y, theta = places[place, 0], places[place, 1], places[place, 2]
        transform = x, y, math.cos(theta), math.sin(theta)
        for k in range(len(points)):
            room = _distance_at(cells, frame, transform, points[k, 0], points[k, 1])
            result[place] = min(result[place], room)
    return result


@compiled()
def reaches(
    places: Array,
    steps: Array,
    rim: Array,
    known: NDArray[np.bool_],
    cells: Cells,
    frame: Array,
    margin: float,
) -> NDArray[np.int64]:
    """Return how many steps (n,) robots at places (n, 3) go until their outline comes to a wall.

    Args:
        places: where the robot may be.
        steps: (s, 3) its poses on the way, in its frame at the start; the first is the start.
        rim: (k, 2) points on its outline [m].
        known: (s, k) points that come to floor that was seen free: no wall is there.
        cells: distances to walls.
        frame: of the cells.
        margin: room that is kept [m]; a robot that has less at its start keeps that.
    """
    result = np.zeros(len(places), np.int64)
    # Where its middle is so far from walls, no point on the outline need be looked at; the distance
    # is that of a cell's middle.
    radius = 0.0
    for k in range(len(rim)):
        radius = max(radius, math.hypot(rim[k, 0], rim[k, 1]))
    far = radius + margin + 2.0 * frame[2]
    for place in range(len(places)):
        x, y, theta = places[place, 0], places[place, 1], places[place, 2]
        turned_cos, turned_sin = math.cos(theta), math.sin(theta)
        kept = margin
        for step in range(len(steps)):
            to_x = x + turned_cos * steps[step, 0] - turned_sin * steps[step, 1]
            to_y = y + turned_sin * steps[step, 0] + turned_cos * steps[step, 1]
            if _distance(cells, frame, to_x, to_y) >= far:
                result[place] = step
                continue
            turned = theta + steps[step, 2]
            transform = to_x, to_y, math.cos(turned), math.sin(turned)
            room = np.inf
            for k in range(len(rim)):
                if not (known[step, k] and step):
                    room = min(room, _distance_at(cells, frame, transform, rim[k, 0], rim[k, 1]))
                    if step and room < kept:
                        break
            if step == 0:
                kept = min(margin, room)
            elif room < kept:
                break
            result[place] = step
    return result


@compiled()
def steps_clear(steps: Array, rim: Array, points: Array, margin: float) -> int:
    """Return how many steps a robot goes until its outline comes to points (n, 2).

    Args:
        steps: (s, 3) its poses on the way; the first is the start.
        rim: (k, 2) points on its outline [m].
        points: in the frame of the steps [m].
        margin: room that is kept [m]; a robot that has less at its start keeps that.
    """
    kept = margin
    for step in range(len(steps)):
        x, y = steps[step, 0], steps[step, 1]
        cos, sin = math.cos(steps[step, 2]), math.sin(steps[step, 2])
        room = np.inf
        for k in range(len(rim)):
            left = x + cos * rim[k, 0] - sin * rim[k, 1]
            up = y + sin * rim[k, 0] + cos * rim[k, 1]
            for n in range(len(points)):
                away = (points[n, 0] - left) ** 2 + (points[n, 1] - up) ** 2
                room = min(room, away)
        room = math.sqrt(room)
        if step == 0:
            kept = min(margin, room)
        elif room < kept:
            return step - 1
    return len(steps) - 1


@compiled()
def ranges_from(places: Array, bearings: Array, sight: Array, cells: Cells, frame: Array) -> Array:
    """Return the ranges (n, k) [m] that a robot sees from places (n, 3); what is far is alike.

    A ray that begins on tape tells nothing: it counts as one that sees nothing.

    Args:
        places: where the robot is.
        bearings: (k,) of rays [rad].
        sight: nearest and farthest that is seen [m].
        cells: distances to tape.
        frame: of the cells.
    """
    result = np.full((len(places), len(bearings)), sight[1])
    for place in range(len(places)):
        for k in range(len(bearings)):
            heading = places[place, 2] + bearings[k]
            cos, sin = math.cos(heading), math.sin(heading)
            along = sight[0]
            while along < sight[1]:
                free = _distance(
                    cells, frame, places[place, 0] + along * cos, places[place, 1] + along * sin
                )
                if free <= 0.0:
                    if along > sight[0]:
                        result[place, k] = along
                    break
                along += max(min(free, sight[1]), frame[2])
    return result
