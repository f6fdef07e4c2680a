"""``random_corners``: RRT*, a tree that grows at random and gets shorter (Karaman, Frazzoli 2011).

For teaching: A* on the grid finds a shorter way sooner. The random numbers are the same each time,
so a drive repeats.
"""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Array, Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.planning import NoWayError

SAMPLES = 1500
"""Places that are drawn."""
STRIDE = 0.15
"""Longest branch [m]."""
GOAL_SHARE = 0.1
"""Share of the places that are the goal."""
NEAR_M = 0.3
"""Branches are compared with all that are so near [m]."""
APART = 0.005
"""A branch is looked at in points so far from each other [m]."""
SEED = 0
"""Of the places that are drawn: equal journeys have equal ways."""


def random_corners(free: FreeSpace, begin: Pose2, end: Pose2) -> Array:
    """Return the corners (n, 2) [m] of a way between two places where the robot may turn.

    Raises:
        NoWayError: none of the branches has come to the end.
    """
    rng = np.random.default_rng(SEED)
    rows, columns = free.distance.shape
    low = np.array(free.origin)
    size = np.array([columns, rows]) * free.side
    goal = np.array([end.x, end.y])
    places = np.empty((SAMPLES + 2, 2))
    parents = np.full(SAMPLES + 2, -1)
    ways = np.zeros(SAMPLES + 2)
    places[0], count, best = (begin.x, begin.y), 1, -1
    for _ in range(SAMPLES):
        wanted = goal if rng.random() < GOAL_SHARE else low + rng.random(2) * size
        away = np.hypot(*(places[:count] - wanted).T)
        nearest = int(np.argmin(away))
        if away[nearest] == 0:
            continue
        stride = min(1.0, STRIDE / away[nearest])
        place = places[nearest] + stride * (wanted - places[nearest])
        if not _is_open(free, places[nearest], place):
            continue
        near = np.flatnonzero(np.hypot(*(places[:count] - place).T) < NEAR_M)
        lengths = np.hypot(*(places[near] - place).T)
        open_ones = np.array([_is_open(free, places[each], place) for each in near])
        through = np.where(open_ones, ways[near] + lengths, math.inf)
        parent = int(np.argmin(through))
        places[count], parents[count], ways[count] = place, near[parent], through[parent]
        # Whoever is nearer through the new place gets it as a parent.
        for each, length, is_open in zip(near, lengths, open_ones, strict=True):
            if is_open and ways[count] + length < ways[each] - 1e-9:
                parents[each], ways[each] = count, ways[count] + length
        if np.array_equal(place, goal) and (best < 0 or ways[count] < ways[best]):
            best = count
        count += 1
    if best < 0:
        raise NoWayError(
            f"{SAMPLES} random places have shown no way; valid is the planner grid, which finds "
            "every way"
        )
    return _shortened(free, _traced(places, parents, best))


def _traced(places: Array, parents: Array, place: int) -> Array:
    path = []
    while place >= 0:
        path.append(places[place])
        place = int(parents[place])
    return np.array(path[::-1])


def _shortened(free: FreeSpace, path: Array) -> Array:
    """Leave out corners that a straight line makes needless."""
    kept, corner = [path[0]], 0
    while corner < len(path) - 1:
        after = next(
            place
            for place in range(len(path) - 1, corner, -1)
            if place == corner + 1 or _is_open(free, path[corner], path[place])
        )
        kept.append(path[after])
        corner = after
    return np.array(kept)


def _is_open(free: FreeSpace, begin: Array, end: Array) -> bool:
    """Whether the robot may have any heading all along a straight line."""
    parts = max(1, math.ceil(math.dist(begin, end) / APART))
    points = begin + np.linspace(0.0, 1.0, parts + 1)[:, None] * (end - begin)
    return free.turns(points)
