"""Grids to start from: around a pose, from a cloud, all over the field."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import count

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.filter import Cloud
from robot.localization.grid.pose_grid import Boxes, Indices, PoseGrid, sum_alike

WIDEST = 3.5
"""A normal distribution is cut off at so many standard deviations."""
WIDEST_LEVEL = 40
"""Boxes so often doubled reach from the map's origin to anywhere."""


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

    A few poses are not draws from something wider: they are put into boxes of level 0. Poses all
    over the field stay apart however wide the boxes are, by the quarter of the map and by heading:
    of them no more are asked than boxes as wide as the world hold.
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
    """Part of each mass goes to the next box along an axis, on the side that it is off (n,)."""
    beside = cells.copy()
    beside[:, axis] += np.where(offset < 0, -1, 1)
    part = np.abs(offset)
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
