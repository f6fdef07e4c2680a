"""Where on the field does a short map fit? The whole field is searched, a little at a time.

First a coarse grid of poses is scored by how far the ends of the map's rays lie from edges; then
the best peaks are laid on the edges exactly, and weighed by casting the rays, so that an edge that
should have been seen and was not counts too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array, Pose2
from robot.localization.hypotheses.local_map import LocalMap
from robot.localization.models.entry_field import EntryField
from robot.localization.scan_matching import Life, ScanMatcher


@dataclass(frozen=True, slots=True)
class SearchSettings:
    """How finely the field is searched."""

    step_xy: float
    """Cell of the coarse grid [m]."""
    step_theta: float
    """[rad]"""
    blur: float
    """How far the coarse grid lets ends lie off [m]."""
    peaks: int = 90
    most: int = 24
    poses_a_slice: int = 40_000
    fits_a_slice: int = 45


@dataclass(frozen=True, slots=True)
class Place:
    """A pose at which the map fits."""

    pose: Pose2
    """Of the robot, where the map's rays are seen from."""
    log_likelihood: float
    """Per ray."""
    life: Life | None = None


class PlaceSearch:
    """One search, done in pieces so that no frame has to wait for it."""

    def __init__(
        self,
        local: LocalMap,
        motion,
        alive,
        entries: EntryField,
        matcher: ScanMatcher,
        settings: SearchSettings,
    ) -> None:
        self.rays = local.rays(12, 12)
        self._few = local.rays(12, 6)
        self.entries = len(local)
        self._alive = alive
        self.past = local.past(8, 30, motion)
        self.found: list[Place] = []
        """Best first, once all is done."""
        self._entries = entries
        self._matcher = matcher
        self._settings = settings
        self._pieces = self._work()

    def advance(self) -> bool:
        """Do a piece of the work; true when all of it is done."""
        return next(self._pieces, True)

    def _work(self) -> Iterator[bool]:
        grid = PoseGrid.over(self._entries, self._settings)
        costs = np.empty(grid.shape, dtype=np.float32)
        ends = _ends(self._few)
        a_slice = max(1, self._settings.poses_a_slice // (grid.shape[1] * grid.shape[2]))
        for first in range(0, grid.shape[0], a_slice):
            turns = slice(first, first + a_slice)
            _score(
                ends,
                grid.thetas[turns],
                grid.xs,
                grid.ys,
                self._entries.distances,
                self._entries.origin,
                self._entries.resolution,
                self._settings.blur,
                costs[turns],
            )
            yield False
        peaks = grid.poses(_peaks(costs, self._settings.peaks))
        places = []
        for first in range(0, len(peaks), self._settings.fits_a_slice):
            places += [
                self._fit(pose) for pose in peaks[first : first + self._settings.fits_a_slice]
            ]
            yield False
        found = distinct(places, 0.06, 0.2)[: self._settings.most]
        found = [p for p in found if p.log_likelihood > found[0].log_likelihood - 1.5]
        self.alive = []
        for first in range(0, len(self._alive), 12):
            self.alive += [
                self._matcher.relive(self._matcher.match(p, self.rays).pose, self.past)
                for p in self._alive[first : first + 12]
            ]
            yield False
        for first in range(0, len(found), 12):
            self.found += [
                replace(p, life=self._matcher.relive(p.pose, self.past))
                for p in found[first : first + 12]
            ]
            yield False
        yield True

    def _fit(self, start: Array) -> Place:
        match = self._matcher.match(Pose2(*start.tolist()), self.rays)
        fit = self._matcher.log_likelihood(match.pose, self.rays)
        return Place(match.pose, fit)


@dataclass(frozen=True, slots=True)
class PoseGrid:
    """Poses, evenly over a field."""

    thetas: Array
    ys: Array
    xs: Array

    @classmethod
    def over(cls, entries: EntryField, settings: SearchSettings) -> PoseGrid:
        """Cover the edges' bounding box and every heading."""
        _, height, width = entries.distances.shape
        margin = entries.max_distance
        low = np.array(entries.origin) + margin
        high = (
            np.array(entries.origin)
            + np.array([width - 1, height - 1]) * entries.resolution
            - margin
        )
        turns = round(2 * math.pi / settings.step_theta)
        x, y = (_centred(low[k], high[k], settings.step_xy) for k in (0, 1))
        return cls(np.arange(turns) * (2 * math.pi / turns) - math.pi, y, x)

    @property
    def shape(self) -> tuple[int, int, int]:
        """How many headings, rows and columns."""
        return len(self.thetas), len(self.ys), len(self.xs)

    def poses(self, cells: NDArray[np.int64]) -> Array:
        """Poses (n, 3) of cells (n, 3): heading, row, column."""
        return np.column_stack(
            [self.xs[cells[:, 2]], self.ys[cells[:, 1]], self.thetas[cells[:, 0]]]
        )


def distinct(places: list[Place], near_xy: float, near_theta: float) -> list[Place]:
    """The places, best first, without those that are about where a better one is."""
    kept: list[Place] = []
    for one in sorted(places, key=lambda place: -place.log_likelihood):
        if not any(
            one.pose.distance_to(k.pose) < near_xy and abs(one.pose.turn_to(k.pose)) < near_theta
            for k in kept
        ):
            kept.append(one)
    return kept


def _centred(low: float, high: float, step: float) -> Array:
    count = max(1, math.ceil((high - low) / step))
    return (low + high) / 2 + step * (np.arange(count) - (count - 1) / 2)


def _ends(rays: Array) -> Array:
    """End and direction (n, 3) of the rays that returned."""
    hit = rays[np.isfinite(rays[:, 3])]
    return np.column_stack(
        [
            hit[:, 0] + hit[:, 3] * np.cos(hit[:, 2]),
            hit[:, 1] + hit[:, 3] * np.sin(hit[:, 2]),
            hit[:, 2],
        ]
    )


@njit(cache=True, nogil=True)
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
    """Cost (t, y, x) of each pose: sum over the ends of d^2 / (d^2 + blur^2)."""
    directions, height, width = distances.shape
    costs[:] = 0
    step = (xs[1] - xs[0]) / resolution if len(xs) > 1 else 0.0
    square = np.float32(blur * blur)
    for t in range(len(thetas)):
        c, s = math.cos(thetas[t]), math.sin(thetas[t])
        for i in range(len(ends)):
            off_x = c * ends[i, 0] - s * ends[i, 1]
            off_y = s * ends[i, 0] + c * ends[i, 1]
            toward = (thetas[t] + ends[i, 2]) * (directions / (2 * math.pi))
            facing = int(math.floor(toward + 0.5)) % directions
            first = (xs[0] + off_x - origin[0]) / resolution + 0.5
            for y in range(len(ys)):
                row = int(math.floor((ys[y] + off_y - origin[1]) / resolution + 0.5))
                if 0 <= row < height:
                    line = distances[facing, row]
                    for x in range(len(xs)):
                        column = int(math.floor(first + x * step))
                        if 0 <= column < width:
                            d = line[column] * line[column]
                            costs[t, y, x] += d / (d + square)
                        else:
                            costs[t, y, x] += np.float32(1)
                else:
                    costs[t, y] += np.float32(1)


@njit(cache=True, nogil=True)
def _peaks(costs: NDArray[np.float32], most: int) -> NDArray[np.int64]:
    """Cells (n, 3) that cost no more than their neighbours, the cheapest, in order."""
    turns, height, width = costs.shape
    cells = []
    for t in range(turns):
        for y in range(height):
            for x in range(width):
                if _is_lowest(costs, t, y, x):
                    cells.append((costs[t, y, x], t, y, x))
    cells.sort()
    count = min(most, len(cells))
    found = np.empty((count, 3), dtype=np.int64)
    for i in range(count):
        _, found[i, 0], found[i, 1], found[i, 2] = cells[i]
    return found


@njit(cache=True, nogil=True)
def _is_lowest(costs: NDArray[np.float32], t: int, y: int, x: int) -> bool:
    turns, height, width = costs.shape
    for dt in (-1, 0, 1):
        for v in range(max(y - 1, 0), min(y + 2, height)):
            for u in range(max(x - 1, 0), min(x + 2, width)):
                if costs[(t + dt) % turns, v, u] < costs[t, y, x]:
                    return False
    return True
