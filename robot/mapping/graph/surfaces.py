"""The surfaces that a laser's scan shows: the ends of its beams, and which way they face."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.mapping.grid.beams import Beams
from robot.scan import evenly

RADIUS = 0.25
"""A surface's direction is that of the ends around a point, up to this distance [m]."""
FEWEST = 2
"""... and of at least this many to either side, where beams are far apart."""
GAP = 0.2
"""Neighbouring ends are of one surface if they are nearer than this [m] ..."""
SLANT = 7.0
"""... or nearer than this many times the distance of neighbouring beams there: beams that meet a
surface aslant do so far apart."""
ROUGH = 0.05
"""If ends scatter more than this about a line [m, standard deviation], there is no wall."""
RANGE_SD = 0.01
"""Least standard deviation of an end [m]."""
MOST = 240
"""How many ends of a scan are used; neighbours have the same errors."""


class Surfaces(NamedTuple):
    """The ends of a scan's beams as pieces of surface, in the robot's frame."""

    points: Array
    """(n, 2) [m]"""
    normals: Array
    """(n, 2) unit vectors that point from the surface to the laser; zeros if nothing tells."""
    spread: Array
    """(n,) variance of the normals' directions [rad²]."""
    joined: NDArray[np.bool_]
    """(n,) whether a point and the one before are of one surface."""

    @classmethod
    def of_beams(cls, beams: Beams) -> Surfaces:
        """Return the surfaces that beams met, which lie in the order of their bearings."""
        ends = np.ascontiguousarray(beams.end[beams.hit])
        origin = beams.begin[beams.hit]
        normals, spread, joined = surface_normals(ends, np.ascontiguousarray(origin))
        used = evenly(len(ends), MOST)
        # A thinned point is joined to the one before if all between them are.
        breaks = np.cumsum(~joined)
        together = np.zeros(len(used), bool)
        together[1:] = np.diff(breaks[used]) == 0
        return cls(ends[used], normals[used], spread[used], together)

    def __len__(self) -> int:
        return len(self.points)

    def lines(self, pose: Pose2) -> Array:
        """Return the pieces of surface (m, 4) between points, seen from a pose's frame [m]."""
        placed = pose.apply(self.points)
        before = np.where(self.joined[:, None], np.roll(placed, 1, axis=0), placed)
        return np.hstack([before, placed])


@compiled()
def surface_normals(points: Array, origins: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return normals (n, 2), the variances of their directions (n,), and what is joined (n,).

    Args:
        points: (n, 2) ends of beams, in the order of their bearings [m].
        origins: (n, 2) where the beams begin [m].
    """
    count = len(points)
    normals, spread = np.zeros((count, 2)), np.full(count, np.inf)
    joined = np.zeros(count, np.bool_)
    apart = SLANT * _step(points - origins)
    for i in range(1, count):
        far = math.hypot(points[i, 0] - origins[i, 0], points[i, 1] - origins[i, 1])
        gap = math.hypot(points[i, 0] - points[i - 1, 0], points[i, 1] - points[i - 1, 1])
        joined[i] = gap < max(GAP, apart * far)
    for i in range(count):
        low = high = i
        while low > 0 and joined[low] and (i - low < FEWEST or _near(points, i, low - 1)):
            low -= 1
        while (
            high < count - 1
            and joined[high + 1]
            and (high - i < FEWEST or _near(points, i, high + 1))
        ):
            high += 1
        if high - low < 2:
            continue
        _fit(points[low : high + 1], points[i] - origins[i], normals[i], spread[i : i + 1])
    return normals, spread, joined


@compiled()
def _step(beams: Array) -> float:
    """Return the angle from beam to beam [rad], typically."""
    if len(beams) < 2:
        return 0.0
    turns = np.diff(np.arctan2(beams[:, 1], beams[:, 0]))
    return float(np.median(np.abs((turns + math.pi) % (2 * math.pi) - math.pi)))


@compiled(inline="always")
def _near(points: Array, i: int, k: int) -> bool:
    return math.hypot(points[i, 0] - points[k, 0], points[i, 1] - points[k, 1]) < RADIUS


@compiled()
def _fit(points: Array, beam: Array, normal: Array, spread: Array) -> None:
    """Write the normal (2,) of a line through points, and its direction's variance (1,)."""
    n = len(points)
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    xx = yy = xy = 0.0
    for k in range(n):
        dx, dy = points[k, 0] - mx, points[k, 1] - my
        xx, yy, xy = xx + dx * dx, yy + dy * dy, xy + dx * dy
    along = 0.5 * math.atan2(2 * xy, xx - yy)
    root = math.hypot(0.5 * (xx - yy), xy)
    major, minor = 0.5 * (xx + yy) + root, max(0.0, 0.5 * (xx + yy) - root)
    sd = math.sqrt(minor / (n - 2)) if n > 2 else 0.0
    if sd > ROUGH or minor > 0.1 * major:
        return
    normal[0], normal[1] = -math.sin(along), math.cos(along)
    if normal[0] * beam[0] + normal[1] * beam[1] > 0:
        normal[0], normal[1] = -normal[0], -normal[1]
    spread[0] = max(sd, RANGE_SD) ** 2 / major
