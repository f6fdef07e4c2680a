"""``shortest_arcs``: the shortest way of a car that only drives ahead (Dubins 1957), compiled.

An arc, a straight line and an arc: LSL, RSR, LSR or RSL. Ways of three arcs, which are shorter only
between places nearer than four radii, are left out.
"""

from __future__ import annotations

import math

import numpy as np

from robot.compiling import compiled
from robot.geometry import Array

WORDS = 4
"""Left or right first, and left or right last, with a straight line between them."""


@compiled()
def shortest_arcs(start: Array, goal: Array, radius: float) -> Array:
    """Return (first side, first angle, straight length, last side, last angle) from a pose to one.

    Args:
        start: (3,) [m, m, rad].
        goal: (3,).
        radius: of the arcs [m].

    Returns:
        Sides are 1 (left) and -1 (right), angles [rad] and the length [m] are not negative.
    """
    best = np.zeros(5)
    shortest = math.inf
    for word in range(WORDS):
        first = 1.0 if word % 2 == 0 else -1.0
        last = first if word < 2 else -first
        # The middles of the circles, to the side of both poses.
        from_x = start[0] - first * radius * math.sin(start[2])
        from_y = start[1] + first * radius * math.cos(start[2])
        to_x = goal[0] - last * radius * math.sin(goal[2])
        to_y = goal[1] + last * radius * math.cos(goal[2])
        along_x, along_y = to_x - from_x, to_y - from_y
        apart, towards = math.hypot(along_x, along_y), math.atan2(along_y, along_x)
        if first == last:
            straight, heading = apart, towards
        else:
            if apart < 2 * radius:
                continue
            straight = math.sqrt(apart * apart - 4 * radius * radius)
            heading = towards + first * math.asin(2 * radius / apart)
        begun = (first * (heading - start[2])) % (2 * math.pi)
        ended = (last * (goal[2] - heading)) % (2 * math.pi)
        # A turn of nothing may come out as a whole one.
        begun = 0.0 if begun > 2 * math.pi - 1e-9 else begun
        ended = 0.0 if ended > 2 * math.pi - 1e-9 else ended
        length = straight + radius * (begun + ended)
        if length < shortest:
            shortest = length
            best[0], best[1], best[2], best[3], best[4] = first, begun, straight, last, ended
    return best


@compiled()
def along_arcs(start: Array, arcs: Array, radius: float, step: float) -> Array:
    """Return poses (n, 3) along such a way, so far from each other [m] or a little less."""
    lengths = np.array([radius * arcs[1], arcs[2], radius * arcs[4]])
    bends = np.array([arcs[0] / radius, 0.0, arcs[3] / radius])
    count = 1
    for part in range(3):
        count += int(math.ceil(lengths[part] / step))
    poses = np.empty((count, 3))
    x, y, theta = start[0], start[1], start[2]
    poses[0, 0], poses[0, 1], poses[0, 2] = x, y, theta
    place = 1
    for part in range(3):
        steps = int(math.ceil(lengths[part] / step))
        for _ in range(steps):
            length, turn = lengths[part] / steps, bends[part] * lengths[part] / steps
            chord = length if abs(turn) < 1e-9 else length * math.sin(turn / 2) / (turn / 2)
            x += chord * math.cos(theta + turn / 2)
            y += chord * math.sin(theta + turn / 2)
            theta += turn
            poses[place, 0], poses[place, 1], poses[place, 2] = x, y, theta
            place += 1
    return poses
