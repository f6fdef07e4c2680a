"""Finds the centre lines of tape in the cloud of points that pictures from known poses saw.

A ray that enters tape by one edge and leaves it by the other has its middle on the centre line, at
whatever angle it crosses. The middles of all pictures are thinned to cells, and lines are followed
from cell to cell.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from robot.geometry import Array

CELL = 0.012
"""Side of a cell [m]."""
DIRECTIONS = 6
"""Number of directions whose lines have cells of their own, so that lines that cross do not mix."""
STRIDE = 1 << 24
"""More cells than any map has side by side."""
LEAST_SURE = 1 / 6
"""Share of a line's cells that enough pictures saw, without those around them."""
NEIGHBOUR = 0.08
"""Rays that meet the same tape have their middles closer together than this [m]."""
WIDTH_ERROR = 0.012
"""Tape that seems wider or narrower than this is none, or a corner [m]."""
REACH = 0.05
"""A line goes on if its next cell is nearer than this [m]."""
BEND = math.radians(28)
"""... and if its direction there differs by less than this [rad]."""
CORNER, SHARP = 5, math.radians(50)
"""A line that turns by this angle [rad] within this many points goes round a corner, and ends
before it: tape does not bend as sharply."""
ASIDE = 0.014
"""Cells within this distance of a line belong to it [m]."""


@dataclass(frozen=True, eq=False)
class Middles:
    """Points on the centre lines of tape, as pictures saw them."""

    points: Array
    """(n, 2) in the map [m]."""
    directions: Array
    """(n,) of the tape, modulo pi [rad]."""
    picture: NDArray[np.intp]
    """(n,) which picture saw it."""

    @classmethod
    def of(cls, floor: Array, poses: Array, width: float) -> Middles:
        """Return the middles of tape of a width [m].

        Args:
            floor: (k, 2 r, 2) where rays enter tape, then where they leave it, in the robot's frame
                [m]; nan without tape.
            poses: (k, 3) of the robot in the map [m, m, rad].
        """
        rays = floor.shape[1] // 2
        near, far = floor[:, :rays], floor[:, rays:]
        middle = (near + far) / 2
        after = np.full_like(middle, np.nan)
        after[:, :-1] = middle[:, 1:] - middle[:, :-1]
        after[np.hypot(after[..., 0], after[..., 1]) > NEIGHBOUR] = np.nan
        before = np.full_like(after, np.nan)
        before[:, 1:] = after[:, :-1]
        along = np.nan_to_num(after) + np.nan_to_num(before)
        length = np.hypot(along[..., 0], along[..., 1])
        chord = far - near
        with np.errstate(invalid="ignore", divide="ignore"):
            across = np.abs(chord[..., 0] * along[..., 1] - chord[..., 1] * along[..., 0]) / length
            good = (length > 0) & (np.abs(across - width) < WIDTH_ERROR)
        picture, ray = np.nonzero(good)
        pose, local = poses[picture], middle[picture, ray]
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        x = pose[:, 0] + c * local[:, 0] - s * local[:, 1]
        y = pose[:, 1] + s * local[:, 0] + c * local[:, 1]
        direction = np.arctan2(along[..., 1], along[..., 0])[picture, ray] + pose[:, 2]
        return cls(np.column_stack([x, y]), np.mod(direction, math.pi), picture)


@dataclass(frozen=True, eq=False)
class MiddleCells:
    """Middles that lie close together and have about the same direction, as their means."""

    points: Array
    """(c, 2) [m]"""
    along: Array
    """(c, 2) unit vectors; either of two opposite ones."""
    counts: NDArray[np.intp]
    """(c,) number of middles."""
    sure: NDArray[np.bool_]
    """(c,) whether enough pictures saw it, without those around it."""

    @classmethod
    def of(cls, middles: Middles, least_pictures: int, *, sparse: bool) -> MiddleCells:
        """Return the cells that at least this many pictures saw.

        Args:
            middles: what pictures saw.
            least_pictures: that saw a cell.
            sparse: whether pictures of the cells around count, too. Beside a robot that drives
                along tape, rays meet it centimetres apart, and the next picture is centimetres
                farther: none of these cells alone is seen often.
        """
        places = np.floor(middles.points / CELL).astype(np.int64)
        sector = np.floor(middles.directions * (DIRECTIONS / math.pi)).astype(np.int64)
        keys = _keys(places, np.minimum(sector, DIRECTIONS - 1))
        own, cell = np.unique(keys, return_inverse=True)
        counts = np.bincount(cell)
        sure = _pictures(own, keys, middles.picture, around=False) >= least_pictures
        kept = sure
        if sparse:
            kept = _pictures(own, keys, middles.picture, around=True) >= least_pictures
        doubled = 2 * middles.directions
        sums = [
            np.bincount(cell, weights=values)
            for values in (*middles.points.T, np.cos(doubled), np.sin(doubled))
        ]
        half = np.arctan2(sums[3], sums[2]) / 2
        means = np.column_stack(sums[:2]) / counts[:, None]
        along = np.column_stack([np.cos(half), np.sin(half)])
        return cls(means[kept], along[kept], counts[kept], sure[kept])


def _keys(places: NDArray[np.int64], sector: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return one number for each cell, by its place (n, 2) and its direction."""
    return (places[:, 0] * STRIDE + places[:, 1]) * DIRECTIONS + sector


def _pictures(
    own: NDArray[np.int64],
    keys: NDArray[np.int64],
    picture: NDArray[np.intp],
    *,
    around: bool,
) -> NDArray[np.intp]:
    """Return how many pictures saw each cell (c,), or it and the eight around it."""
    near = (-1, 0, 1) if around else (0,)
    steps = np.array([x * STRIDE + y for x in near for y in near]) * DIRECTIONS
    wanted = keys[:, None] + steps
    cell = np.minimum(np.searchsorted(own, wanted), len(own) - 1)
    most = int(picture.max(initial=0)) + 1
    seen = np.unique((cell * most + picture[:, None])[own[cell] == wanted])
    return np.bincount(seen // most, minlength=len(own))


def trace(cells: MiddleCells) -> list[Array]:
    """Return lines, each (n, 2) points [m] in order, the most often seen first.

    A closed line repeats its first point.
    """
    if not len(cells.points):
        return []
    tracer = _Tracer(cells)
    lines = []
    for seed in np.argsort(-cells.counts, kind="stable"):
        if tracer.free[seed]:
            lines.append(tracer.line(int(seed)))
    return [line for line in lines if len(line) > 2 and _is_sure(line, cells)]


def _is_sure(line: Array, cells: MiddleCells) -> bool:
    """Return whether enough of a line's cells were seen often by themselves."""
    away, _ = cKDTree(line).query(cells.points)
    return float(cells.sure[away < ASIDE].mean()) >= LEAST_SURE


class _Tracer:
    def __init__(self, cells: MiddleCells) -> None:
        self._cells = cells
        self._tree = cKDTree(cells.points)
        self.free = np.ones(len(cells.points), bool)
        """(c,) which cells belong to no line yet."""

    def line(self, seed: int) -> Array:
        """Follow a line from a cell, both ways."""
        start, heading = self._cells.points[seed], self._cells.along[seed]
        self.free[seed] = False
        ahead, closed = self._follow(start, heading)
        if closed:
            return np.vstack([start, *ahead, start])
        behind, _ = self._follow(start, -heading)
        return np.vstack([*behind[::-1], start, *ahead])

    def _follow(self, start: Array, heading: Array) -> tuple[list[Array], bool]:
        cells = self._cells
        points: list[Array] = []
        headings = [heading]
        place = start
        while True:
            near = np.array(self._tree.query_ball_point(place, REACH), dtype=np.intp)
            away = cells.points[near] - place
            forward = away @ heading
            aside = np.abs(away[:, 0] * heading[1] - away[:, 1] * heading[0])
            same = np.abs(cells.along[near] @ heading) > math.cos(BEND)
            on_line = same & (aside < np.minimum(ASIDE, 0.004 + 0.3 * np.abs(forward)))
            fresh = on_line & self.free[near] & (forward > 0.002)
            if not fresh.any():
                # Back at its own start, the line is closed.
                closed = len(points) > 10 and math.dist(place, start) < REACH
                return points, closed and bool((start - place) @ heading > 0)
            step = forward[fresh].min() + CELL
            chosen = near[fresh & (forward <= step)]
            share = cells.counts[chosen] / cells.counts[chosen].sum()
            following = share @ cells.points[chosen]
            signs = np.sign(cells.along[chosen] @ heading)
            turned = heading + (share * signs) @ cells.along[chosen]
            self.free[chosen] = False
            self._take_beside(place, following)
            heading = turned / math.hypot(*turned)
            place = following
            points.append(following)
            headings.append(heading)
            if len(headings) > CORNER and headings[-1 - CORNER] @ heading < math.cos(SHARP):
                return points[:-CORNER], False

    def _take_beside(self, start: Array, end: Array) -> None:
        """Take the cells beside a step, so that no second line runs along the first."""
        along = end - start
        length = math.hypot(*along)
        if length < 1e-9:
            return
        along = along / length
        near = np.array(self._tree.query_ball_point((start + end) / 2, length / 2 + ASIDE))
        away = self._cells.points[near] - start
        forward, aside = away @ along, np.abs(away[:, 0] * along[1] - away[:, 1] * along[0])
        same = np.abs(self._cells.along[near] @ along) > math.cos(1.5 * BEND)
        taken = same & (aside < ASIDE) & (forward > -0.002) & (forward < length + 0.002)
        self.free[near[taken]] = False
