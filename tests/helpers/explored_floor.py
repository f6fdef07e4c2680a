"""A floor of lines, and a robot that explores it: seen by geometry alone, without pictures."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.spatial import cKDTree

from robot.driving.route import Route
from robot.fields.occupancy_grid import OCCUPIED, UNKNOWN, OccupancyGrid
from robot.geometry import Pose2, wrap_angle
from robot.mapping.exploring import Explorer
from robot.mapping.sketch import Sketch

TICK = 0.02
CELL, SAMPLE, WIDTH = 0.02, 0.02, 0.05
BEGIN, REACH, HALF_ANGLE = 0.16, 0.85, math.radians(26)
"""Rays of the described robot: where they begin, how far ahead they end [m], and their fan."""
RAYS = np.linspace(-HALF_ANGLE, HALF_ANGLE, 61)
STEP, TURN = 0.05, 0.15
"""A picture is taken each so many metres, or radians."""
DRAWN_S = 0.8
"""How long the robot stands until the map has what it saw [s]."""
LONGEST_S = 900.0


def rectangle(left: float, low: float, right: float, high: float) -> np.ndarray:
    """A closed line."""
    return np.array([[left, low], [right, low], [right, high], [left, high], [left, low]])


class DrawnFloor:
    """Lines of tape, and what was seen of them and of the floor."""

    def __init__(self, lines: list[np.ndarray], dark: tuple[float, ...] = ()) -> None:
        """Nothing was seen; floor in the dark (left, low, right, high) is never seen."""
        self._segments = np.concatenate([np.stack([a[:-1], a[1:]], axis=1) for a in lines])
        self._pieces = [_sampled(line) for line in lines]
        self._tape = np.vstack(self._pieces)
        self.seen = np.zeros(len(self._tape), bool)
        low, high = self._tape.min(axis=0) - 1.6, self._tape.max(axis=0) + 1.6
        self._origin = CELL * np.floor(low / CELL)
        columns, rows = np.ceil((high - self._origin) / CELL).astype(int)
        self._cells = np.full((rows, columns), UNKNOWN, np.int8)
        grid = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
        self._middles = CELL * (grid + 0.5) + self._origin
        self._dark = dark
        self._path: list[np.ndarray] = []

    @property
    def share(self) -> float:
        """Of the tape that was seen."""
        return float(self.seen.mean())

    def look(self, pose: Pose2) -> None:
        """Take a picture: rays end at the first tape that they meet."""
        self._path.append(pose.to_array())
        place = np.array([pose.x, pose.y])
        headings = pose.theta + RAYS
        rays = np.column_stack([np.cos(headings), np.sin(headings)])
        start, way = self._segments[:, 0] - place, np.diff(self._segments, axis=1)[:, 0]
        with np.errstate(all="ignore"):
            cross = rays[:, :1] * way[:, 1] - rays[:, 1:] * way[:, 0]
            far = (start[:, 0] * way[:, 1] - start[:, 1] * way[:, 0]) / cross
            along = (start[:, 0] * rays[:, 1:] - start[:, 1] * rays[:, :1]) / cross
        met = np.where((along >= 0) & (along <= 1) & (far > BEGIN), far, np.inf).min(axis=1)
        ends = np.minimum(met - WIDTH / 2, REACH / np.cos(RAYS))
        first, last = (((place + s - self._origin) / CELL).astype(int).clip(0) for s in (-1.0, 1.0))
        near = slice(first[1], last[1]), slice(first[0], last[0])
        shown = _before(self._middles[near] - place, pose.theta, ends)
        if self._dark:
            x, y = self._middles[near].transpose(2, 0, 1)
            left, low, right, high = self._dark
            shown &= ~((x > left) & (x < right) & (y > low) & (y < high))
        self._cells[near][shown] = 0
        self.seen |= _before(self._tape - place, pose.theta, ends + WIDTH)

    def map(self) -> tuple[Sketch | None, OccupancyGrid | None]:
        """The map of what was seen."""
        lines, first = [], 0
        for piece in self._pieces:
            seen = self.seen[first : first + len(piece)].astype(int)
            first += len(piece)
            bounds = np.flatnonzero(np.diff(seen, prepend=0, append=0))
            pairs = zip(bounds[::2], bounds[1::2], strict=True)
            lines += [piece[a:b] for a, b in pairs if b - a >= 3]
        if not lines:
            return None, None
        points = np.vstack(lines)
        beside, _ = cKDTree(points).query(self._middles, distance_upper_bound=WIDTH / 2)
        cells = np.where(np.isfinite(beside), OCCUPIED, self._cells).astype(np.int8)
        path = np.array(self._path) if self._path else np.zeros((1, 3))
        sketch = Sketch(tuple(lines), np.zeros(len(lines)), path, points, 0.0, None)
        return sketch, OccupancyGrid(cells, CELL, Pose2(*self._origin))


@dataclass(frozen=True, eq=False)
class ExploredDrive:
    """A drive that came to its end."""

    seconds: float
    path: list[Pose2]
    unseen: np.ndarray
    """(n, 2) places that are told [m]."""


def explored(floor: DrawnFloor, start: Pose2) -> ExploredDrive:
    """Let a robot with exact wheels explore a floor."""
    explorer, pose, seconds, path = Explorer(), start, 0.0, [start]
    floor.look(pose)
    while (route := next_route(explorer, floor, pose)) is not None:
        seconds += DRAWN_S if explorer.waits else 0.0
        for reached in _driven(route, pose):
            pose = reached
            seconds += TICK
            turned = abs(wrap_angle(pose.theta - path[-1].theta))
            if pose.distance_to(path[-1]) > STEP or turned > TURN:
                floor.look(pose)
                path.append(pose)
        assert seconds < LONGEST_S
        floor.look(pose)
        path.append(pose)
    return ExploredDrive(seconds, path, explorer.unseen)


def next_route(explorer: Explorer, floor: DrawnFloor, pose: Pose2) -> Route | None:
    """The next route, by all that was seen."""
    sketch, cells = floor.map()
    return explorer.next(sketch, pose, cells)


def _driven(route: Route, pose: Pose2) -> Iterator[Pose2]:
    while (twist := route.twist(pose)) is not None:
        pose = pose @ twist.integrate(TICK)
        yield pose


def _before(away: np.ndarray, heading: float, ends: np.ndarray) -> np.ndarray:
    """Which points (..., 2) from the robot rays reach before their ends."""
    distance = np.hypot(away[..., 0], away[..., 1])
    aside = wrap_angle(np.arctan2(away[..., 1], away[..., 0]) - heading)
    ray: np.ndarray = (
        np.rint((aside + HALF_ANGLE) / (RAYS[1] - RAYS[0])).astype(int).clip(0, len(RAYS) - 1)
    )
    reached: np.ndarray = (
        (np.abs(aside) <= HALF_ANGLE) & (distance > BEGIN) & (distance < ends[ray])
    )
    return reached


def _sampled(line: np.ndarray) -> np.ndarray:
    whole = shapely.LineString(line)
    count = max(3, math.ceil(whole.length / SAMPLE) + 1)
    places = np.linspace(0, whole.length, count)
    return shapely.get_coordinates(shapely.line_interpolate_point(whole, places))
