"""An even grid of poses over a field, and how badly the ends of rays fit at each pose."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.fields.floor_picture import Extent
from robot.geometry import Array
from robot.localization.models.entry_field import EntryField

MOST_POSES = 2_000_000
"""Most poses of a grid; a large field gets a coarser one."""
HALVINGS = 2
"""How often the steps are halved when a pose is refined: from 40 mm to 10 mm."""


@dataclass(frozen=True, slots=True, eq=False)
class CoarseGrid:
    """Poses over a box, with all headings."""

    thetas: Array = field(repr=False)
    """(t,) [rad]"""
    ys: Array = field(repr=False)
    """(h,) [m]"""
    xs: Array = field(repr=False)
    """(w,) [m]"""

    @classmethod
    def over(cls, box: Extent, step_xy: float, step_theta: float) -> CoarseGrid:
        """Cover a box [m] in steps [m] and [rad]; steps [m] grow if there are too many poses."""
        low, size = box[:2], np.subtract(box[2:], box[:2])
        turns = max(1, round(2 * math.pi / step_theta))
        step = max(step_xy, math.sqrt(size[0] * size[1] * turns / MOST_POSES))
        thetas = np.linspace(-math.pi, math.pi, turns, endpoint=False)
        return cls(thetas, _evenly(low[1], size[1], step), _evenly(low[0], size[0], step))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of headings, rows and columns."""
        return len(self.thetas), len(self.ys), len(self.xs)

    def poses(self, cells: NDArray[np.int64]) -> Array:
        """Poses (n, 3) of cells (n, 3): heading, row, column."""
        turn, row, column = cells.T
        return np.column_stack([self.xs[column], self.ys[row], self.thetas[turn]])

    def refined_poses(self, poses: Array, ends: Array, entries: EntryField, blur: float) -> Array:
        """Return the poses (n, 3), each moved to the cheapest pose nearby in ever smaller steps.

        At a distance of one grid step, rays lie nearer to other edges than to their own.
        """
        return _refine_poses(
            poses,
            self._steps,
            ends,
            entries.distances,
            entries.origin,
            entries.resolution,
            blur,
        )

    @property
    def _steps(self) -> Array:
        """Steps of x, y and theta [m, m, rad]."""
        return np.array([_step(self.xs), _step(self.ys), 2 * math.pi / len(self.thetas)])

    def score(
        self,
        turns: slice,
        ends: Array,
        entries: EntryField,
        blur: float,
        costs: NDArray[np.float32],
    ) -> None:
        """Fill in the costs (t, h, w) of some headings: sum over the ends of d^2 / (d^2 + blur^2).

        Args:
            ends: (n, 3) end of each ray [m] and its direction [rad], seen from the robot.
            entries: table of the distances to edges.
            blur: distance of an end from an edge that costs one half [m].
            costs: the costs of all headings.
        """
        _score(
            ends,
            self.thetas[turns],
            self.xs,
            self.ys,
            entries.distances,
            entries.origin,
            entries.resolution,
            blur,
            costs[turns],
        )


def _evenly(low: float, size: float, step: float) -> Array:
    count = max(1, math.ceil(size / step))
    half = step * (count - 1) / 2
    return np.linspace(low + size / 2 - half, low + size / 2 + half, count)


def _step(values: Array) -> float:
    return float(values[1] - values[0]) if len(values) > 1 else 0.0


@compiled()
def _refine_poses(
    poses: Array,
    steps: Array,
    ends: Array,
    distances: NDArray[np.float32],
    origin: tuple[float, float],
    resolution: float,
    blur: float,
) -> Array:
    result = poses.copy()
    args = ends, distances, origin, resolution, blur
    tried = np.empty(3)
    for pose in result:
        least = cost_at(pose, *args)
        for halving in range(1, HALVINGS + 1):
            centre = pose.copy()
            for neighbour in range(27):
                for axis, way in enumerate((neighbour % 3, neighbour // 3 % 3, neighbour // 9)):
                    tried[axis] = centre[axis] + (way - 1) * steps[axis] / 2**halving
                cost = cost_at(tried, *args)
                if cost < least:
                    least = cost
                    pose[:] = tried
    return result


@compiled()
def cost_at(
    pose: Array,
    ends: Array,
    distances: NDArray[np.float32],
    origin: tuple[float, float],
    resolution: float,
    blur: float,
) -> float:
    """Sum over the ends of d^2 / (d^2 + blur^2) at one pose."""
    directions, height, width = distances.shape
    c, s = math.cos(pose[2]), math.sin(pose[2])
    cost = 0.0
    for i in range(len(ends)):
        x = pose[0] + c * ends[i, 0] - s * ends[i, 1]
        y = pose[1] + s * ends[i, 0] + c * ends[i, 1]
        toward = (pose[2] + ends[i, 2]) * (directions / (2 * math.pi))
        facing = int(math.floor(toward + 0.5)) & (directions - 1)  # a power of two
        row = int(math.floor((y - origin[1]) / resolution + 0.5))
        column = int(math.floor((x - origin[0]) / resolution + 0.5))
        if 0 <= row < height and 0 <= column < width:
            d = distances[facing, row, column]
            cost += d * d / (d * d + blur * blur)
        else:
            cost += 1.0
    return cost


@compiled()
def _score(
    ends: Array,
    thetas: Array,
    xs: Array,
    ys: Array,
    distances: NDArray[np.float32],
    origin: tuple[float, float],
    resolution: float,
    blur: float,
    costs: NDArray[np.float32],
) -> None:
    directions, height, width = distances.shape
    step = (xs[1] - xs[0]) / resolution if len(xs) > 1 else 0.0
    square, all_of_it = np.float32(blur * blur), np.float32(1)
    costs[:] = 0
    for t in range(len(thetas)):
        c, s = math.cos(thetas[t]), math.sin(thetas[t])
        for i in range(len(ends)):
            off_x, off_y = c * ends[i, 0] - s * ends[i, 1], s * ends[i, 0] + c * ends[i, 1]
            toward = (thetas[t] + ends[i, 2]) * (directions / (2 * math.pi))
            facing = int(math.floor(toward + 0.5)) % directions
            first = (xs[0] + off_x - origin[0]) / resolution + 0.5
            for y in range(len(ys)):
                row = int(math.floor((ys[y] + off_y - origin[1]) / resolution + 0.5))
                if not 0 <= row < height:
                    costs[t, y] += all_of_it
                    continue
                line = distances[facing, row]
                for x in range(len(xs)):
                    column = int(math.floor(first + x * step))
                    if 0 <= column < width:
                        d = line[column] * line[column]
                        costs[t, y, x] += d / (d + square)
                    else:
                        costs[t, y, x] += all_of_it


class Cheapest:
    """The cheapest local minima of a grid: cells that cost no more than their neighbours."""

    def __init__(self, most: int, limit: float) -> None:
        """Keep at most ``most`` cells, in order of cost, and only those cheaper than a limit."""
        self._costs = np.full(most, limit, dtype=np.float32)
        self._cells = np.zeros((most, 3), dtype=np.int64)
        self._limit = limit

    @property
    def cells(self) -> NDArray[np.int64]:
        """(n, 3) heading, row, column."""
        return self._cells[self._costs < self._limit]

    def look(self, costs: NDArray[np.float32], turns: slice) -> None:
        """Search some headings of all costs (t, h, w) for local minima."""
        first, last, _ = turns.indices(len(costs))
        _look(costs, first, last, self._costs, self._cells)


@compiled()
def _look(
    costs: NDArray[np.float32],
    first: int,
    last: int,
    best: NDArray[np.float32],
    cells: NDArray[np.int64],
) -> None:
    """Insert the local minima of some headings into the best ones (n,), in order of cost."""
    _, height, width = costs.shape
    for t in range(first, last):
        for y in range(height):
            for x in range(width):
                if costs[t, y, x] < best[-1] and _is_lowest(costs, t, y, x):
                    place = np.searchsorted(best, costs[t, y, x], side="right")
                    best[place + 1 :] = best[place:-1].copy()
                    cells[place + 1 :] = cells[place:-1].copy()
                    best[place] = costs[t, y, x]
                    cells[place, 0], cells[place, 1], cells[place, 2] = t, y, x


@compiled()
def _is_lowest(costs: NDArray[np.float32], t: int, y: int, x: int) -> bool:
    """Whether no neighbour costs less.

    If only a wall is seen, a whole row of cells costs the same, and each may be the right one.
    """
    turns, height, width = costs.shape
    for dt in (-1, 0, 1):
        for v in range(max(y - 1, 0), min(y + 2, height)):
            for u in range(max(x - 1, 0), min(x + 2, width)):
                if costs[(t + dt) % turns, v, u] < costs[t, y, x]:
                    return False
    return True
