"""A belief on a grid: boxes of x, y and theta, each with a share of the probability.

Only boxes that are not negligible are kept (selective updating: Probabilistic Robotics, section
8.2.3). All boxes have the same size. It is doubled for a wide belief and halved for a narrow one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import count

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.localization.filter import Cloud

Indices = NDArray[np.int64]

FEWEST_TURNS = 8
"""Least number of boxes in a full turn; wider boxes of heading are not made."""
WIDEST = 3.5
"""A normal distribution is cut off at this many standard deviations."""
WIDEST_LEVEL = 40
"""Boxes that were doubled this often reach from the map's origin to any place."""


@dataclass(frozen=True, slots=True)
class Boxes:
    """A partition of the poses into boxes."""

    finest_xy: float
    """Side of a box of level 0 [m]."""
    finest_turns: int
    """Boxes of level 0 in a full turn: a power of two."""
    level: int = 0
    """How often the finest boxes were doubled."""

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
        """Return poses (n, 3) in boxes, from the map's origin and -pi; borders are integers."""
        places: Array = np.add(poses, (0, 0, math.pi)) / self.size
        return places


@dataclass(frozen=True, slots=True, eq=False)
class PoseGrid:
    """Boxes with their probability."""

    boxes: Boxes
    cells: Indices = field(repr=False)
    """(n, 3) indices of the boxes along x, y and theta; all different."""
    mass: Array = field(repr=False)
    """(n,), summing to one."""

    @classmethod
    def of(cls, boxes: Boxes, cells: Indices, mass: Array) -> PoseGrid:
        """Return a grid of boxes (n, 3) with masses (n,); boxes may repeat, headings may wrap."""
        cells[:, 2] %= boxes.turns
        cells, mass = sum_alike(cells, mass)
        return cls(boxes, cells, mass / mass.sum())

    @property
    def poses(self) -> Array:
        """The middles of the boxes (n, 3) [m, m, rad]."""
        middles: Array = (self.cells + 0.5) * self.boxes.size - (0, 0, math.pi)
        return middles

    def only(self, selection: NDArray[np.bool_]) -> PoseGrid:
        """Return a grid of some of the boxes."""
        mass = self.mass[selection]
        return replace(self, cells=self.cells[selection], mass=mass / mass.sum())

    def finer(self) -> PoseGrid:
        """Return a grid with each box cut into eight, of half its sides."""
        half = replace(self.boxes, level=self.boxes.level - 1)
        in_turn = half.turns // self.boxes.turns
        corners = np.array([(x, y, t) for x in (0, 1) for y in (0, 1) for t in range(in_turn)])
        cells = self.cells[:, None] * (2, 2, in_turn) + corners
        mass = np.repeat(self.mass / len(corners), len(corners))
        return PoseGrid(half, cells.reshape(-1, 3), mass)

    def coarser(self) -> PoseGrid:
        """Return a grid with eight boxes joined into one, of twice their sides."""
        double = replace(self.boxes, level=self.boxes.level + 1)
        in_turn = self.boxes.turns // double.turns
        return PoseGrid.of(double, self.cells // (2, 2, in_turn), self.mass)


@compiled()
def sum_alike(cells: Indices, mass: Array) -> tuple[Indices, Array]:
    """Return each box (n, 3) once, with all its mass, in the order of first occurrence.

    Boxes without mass are left out.
    """
    table, merged, total = no_boxes(len(cells))
    result = 0
    for i in range(len(cells)):
        result = add_box(
            cells[i, 0], cells[i, 1], cells[i, 2], mass[i], table, merged, total, result
        )
    return merged[:result].copy(), total[:result].copy()


@compiled()
def no_boxes(most: int) -> tuple[Indices, Indices, Array]:
    """Return an empty hash table, boxes and masses, which ``add_box`` fills."""
    size = 16
    while size < 2 * most:
        size *= 2
    return np.full(size, -1, dtype=np.int64), np.empty((most, 3), dtype=np.int64), np.empty(most)


@compiled(forceinline=True)
def add_box(
    x: int,
    y: int,
    t: int,
    mass: float,
    table: Indices,
    merged: Indices,
    total: Array,
    result: int,
) -> int:
    """Add mass to a box, which may be new; return the number of boxes.

    The table has open addressing: if a box finds its slot taken, it takes the next free one.
    """
    if not mass > 0:
        return result
    # Large odd factors: the products wrap, and their high bits depend on all bits of the places.
    mixed = x * 0x1E3779B97F4A7C15 + y * 0x42B2AE3D27D4EB4F + t * 0x165667B19E3779F9
    slot = ((mixed ^ (mixed >> 32)) * 0x1FD7046C5EF9AB4D >> 20) & (len(table) - 1)
    while table[slot] >= 0:
        position = table[slot]
        if merged[position, 0] == x and merged[position, 1] == y and merged[position, 2] == t:
            total[position] += mass
            return result
        slot = (slot + 1) & (len(table) - 1)
    table[slot] = result
    merged[result, 0], merged[result, 1], merged[result, 2] = x, y, t
    total[result] = mass
    return result + 1


def normal_grid(finest: Boxes, mean: Pose2, covariance: Array, most: int) -> PoseGrid:
    """Return a normal distribution, in the finest boxes with which at most ``most`` are needed.

    It is at least half a box wide; a narrower one would fall between the middles of boxes.

    Args:
        finest: boxes of level 0.
        mean: mean in the map.
        covariance: (3, 3) [m, m, rad], may be singular.
        most: most boxes within the bounds of the distribution.
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
    """Return weighted poses, in the finest boxes that hold four of them each on average.

    A few poses are not draws from a wider distribution, so they are put into boxes of level 0.
    Poses all over the field stay in different boxes of any width, by the quarter of the map and by
    heading, so no more than in the widest boxes are required.
    """
    some = cloud.weights > 0
    poses, weights = cloud.poses[some], cloud.weights[some]
    widest = np.floor(replace(finest, level=WIDEST_LEVEL).places(poses)).astype(np.int64)
    apart, _ = sum_alike(widest, weights)
    most = max(few, len(poses) // 4, len(apart))
    for level in count():
        boxes = replace(finest, level=level)
        places = boxes.places(poses)
        cells = np.floor(places).astype(np.int64)
        occupied, _ = sum_alike(cells, weights)
        if len(occupied) <= most:
            break
    # Shared between the boxes around it, so that a pose is not moved to the middle of its own.
    for axis in range(3):
        cells, weights = _share(cells, weights, axis, places[:, axis] % 1 - 0.5)
        places = np.tile(places, (2, 1))
    return PoseGrid.of(boxes, cells, weights)


def _share(cells: Indices, mass: Array, axis: int, offset: Array) -> tuple[Indices, Array]:
    """Share each mass with the next box along an axis, on the side of its offset (n,)."""
    beside = cells.copy()
    beside[:, axis] += np.where(offset < 0, -1, 1)
    part = np.abs(offset)
    return np.concatenate([cells, beside]), np.concatenate([mass * (1 - part), mass * part])


def even_grid(finest: Boxes, places: Array, most: int) -> PoseGrid:
    """Return a grid with all headings, over places that are spread evenly where the robot may be.

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
