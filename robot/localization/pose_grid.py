"""A belief on a grid: boxes of x, y and theta, each with a share of the probability.

Only boxes that matter are kept (selective updating: Probabilistic Robotics, section 8.2.3). All
have one size, which may be halved and doubled: coarse where the belief is wide, and fine where it
is narrow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import count

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array, Pose2
from robot.localization.filter import Cloud

Indices = NDArray[np.int64]

FEWEST_TURNS = 8
"""Boxes of heading are not doubled any more when a full turn has no more than these."""
WIDEST = 3.5
"""A normal distribution is cut off at so many standard deviations."""


@dataclass(frozen=True, slots=True)
class Boxes:
    """How the poses are cut into boxes."""

    finest_xy: float
    """Side of a box of level 0 [m]."""
    finest_turns: int
    """Boxes of level 0 in a full turn: a power of two."""
    level: int = 0
    """How often the finest boxes are doubled."""

    @property
    def turns(self) -> int:
        """Boxes in a full turn."""
        return max(self.finest_turns >> self.level, FEWEST_TURNS)

    @property
    def size(self) -> Array:
        """Sides (3,) of a box [m, m, rad]."""
        xy = math.ldexp(self.finest_xy, self.level)
        return np.array([xy, xy, 2 * math.pi / self.turns])

    def places(self, poses: Array) -> Array:
        """Poses (n, 3) in boxes from the map's origin and from -pi; whole numbers are borders."""
        places: Array = np.add(poses, (0, 0, math.pi)) / self.size
        return places


@dataclass(frozen=True, slots=True)
class PoseGrid:
    """Boxes with their probability."""

    boxes: Boxes
    cells: Indices = field(repr=False)
    """(n, 3) which box, along x, y and theta; no two alike."""
    mass: Array = field(repr=False)
    """(n,), summing to one."""

    @classmethod
    def of(cls, boxes: Boxes, cells: Indices, mass: Array) -> PoseGrid:
        """Boxes (n, 3) that may occur more than once, with any mass (n,); headings may be wound."""
        cells[:, 2] %= boxes.turns
        cells, mass = sum_alike(cells, mass)
        return cls(boxes, cells, mass / mass.sum())

    @property
    def poses(self) -> Array:
        """The middles of the boxes (n, 3) [m, m, rad]."""
        middles: Array = (self.cells + 0.5) * self.boxes.size - (0, 0, math.pi)
        return middles

    def only(self, which: NDArray[np.bool_]) -> PoseGrid:
        """Some of the boxes."""
        mass = self.mass[which]
        return replace(self, cells=self.cells[which], mass=mass / mass.sum())

    def finer(self) -> PoseGrid:
        """Each box cut into eight, of half its sides."""
        half = replace(self.boxes, level=self.boxes.level - 1)
        in_turn = half.turns // self.boxes.turns
        corners = np.array([(x, y, t) for x in (0, 1) for y in (0, 1) for t in range(in_turn)])
        cells = self.cells[:, None] * (2, 2, in_turn) + corners
        mass = np.repeat(self.mass / len(corners), len(corners))
        return PoseGrid(half, cells.reshape(-1, 3), mass)

    def coarser(self) -> PoseGrid:
        """Eight boxes made one, of twice their sides."""
        double = replace(self.boxes, level=self.boxes.level + 1)
        in_turn = self.boxes.turns // double.turns
        return PoseGrid.of(double, self.cells // (2, 2, in_turn), self.mass)


def normal_grid(finest: Boxes, mean: Pose2, covariance: Array, most: int) -> PoseGrid:
    """A normal distribution, in the finest boxes of which no more than so many are needed.

    It is half a box wide at least: narrower it would fall between their middles.

    Args:
        finest: boxes of level 0.
        mean: in the map.
        covariance: (3, 3) [m, m, rad], may be singular.
        most: boxes within the bounds of the distribution.
    """
    for level in count():
        boxes = replace(finest, level=level)
        wide = covariance + np.diag(np.square(boxes.size / 2))
        reach = np.ceil(WIDEST * np.sqrt(np.diag(wide)) / boxes.size)
        reach[2] = min(reach[2], boxes.turns / 2)
        if np.prod(2 * reach + 1) <= most:
            break
    around = [np.arange(-r, r + 1, dtype=np.int64) for r in reach]
    middle = np.floor(boxes.places(mean.to_array()[None])[0]).astype(np.int64)
    cells = middle + np.stack(np.meshgrid(*around), axis=-1).reshape(-1, 3)
    offsets = (cells + 0.5) * boxes.size - (0, 0, math.pi) - mean.to_array()
    within = np.abs(offsets[:, 2]) <= math.pi
    cells, offsets = cells[within], offsets[within]
    squared = (offsets * np.linalg.solve(wide, offsets.T).T).sum(axis=1)
    near = squared < WIDEST**2
    return PoseGrid.of(boxes, cells[near], np.exp(-0.5 * squared[near]))


def cloud_grid(finest: Boxes, cloud: Cloud, few: int = 8) -> PoseGrid:
    """Weighted poses, in the finest boxes that have four of them each on average.

    A few poses are not draws from something wider: they are put into boxes of level 0.
    """
    some = cloud.weights > 0
    poses, weights = cloud.poses[some], cloud.weights[some]
    for level in count():
        boxes = replace(finest, level=level)
        places = boxes.places(poses)
        cells = np.floor(places).astype(np.int64)
        occupied, _ = sum_alike(cells, weights)
        if len(occupied) <= max(few, len(poses) // 4):
            break
    # Shared between the boxes around it, so that a pose is not moved to the middle of its own.
    for axis in range(3):
        cells, weights = _share(cells, weights, axis, places[:, axis] % 1 - 0.5)
        places = np.tile(places, (2, 1))
    return PoseGrid.of(boxes, cells, weights)


def _share(cells: Indices, mass: Array, axis: int, off: Array) -> tuple[Indices, Array]:
    """Part of each mass goes to the next box along an axis, on the side that it is off (n,)."""
    beside = cells.copy()
    beside[:, axis] += np.where(off < 0, -1, 1)
    part = np.abs(off)
    return np.concatenate([cells, beside]), np.concatenate([mass * (1 - part), mass * part])


def even_grid(finest: Boxes, places: Array, most: int) -> PoseGrid:
    """Any heading, and a place among many that are evenly spread over where the robot may be.

    Args:
        finest: boxes of level 0.
        places: (n, 2) [m]
        most: boxes.
    """
    poses = np.column_stack([places, np.full(len(places), -math.pi)])
    for level in count():
        boxes = replace(finest, level=level)
        cells = np.floor(boxes.places(poses)).astype(np.int64)
        occupied, mass = sum_alike(cells, np.ones(len(cells)))
        if len(occupied) * boxes.turns <= most:
            break
    cells = np.repeat(occupied, boxes.turns, axis=0)
    cells[:, 2] = np.tile(np.arange(boxes.turns), len(occupied))
    return PoseGrid.of(boxes, cells, np.repeat(mass, boxes.turns))


@njit(cache=True, nogil=True)
def sum_alike(cells: Indices, mass: Array) -> tuple[Indices, Array]:
    """Each box (n, 3) once, with all its mass; boxes without any are left out.

    A hash table with open addressing: linear in n, and in the order of the first to come.
    """
    size = 16
    while size < 2 * len(cells):
        size *= 2
    table = np.full(size, -1, dtype=np.int64)
    once, total = np.empty_like(cells), np.empty_like(mass)
    found = 0
    for i in range(len(cells)):
        if not mass[i] > 0:
            continue
        x, y, t = cells[i]
        # Large odd numbers; products wrap, and their high bits depend on all bits of the places.
        mixed = x * 0x1E3779B97F4A7C15 + y * 0x42B2AE3D27D4EB4F + t * 0x165667B19E3779F9
        slot = ((mixed ^ (mixed >> 32)) * 0x1FD7046C5EF9AB4D >> 20) & (size - 1)
        while True:
            at = table[slot]
            if at < 0:
                table[slot] = found
                once[found], total[found] = cells[i], mass[i]
                found += 1
                break
            if once[at, 0] == x and once[at, 1] == y and once[at, 2] == t:
                total[at] += mass[i]
                break
            slot = (slot + 1) & (size - 1)
    return once[:found].copy(), total[:found].copy()
