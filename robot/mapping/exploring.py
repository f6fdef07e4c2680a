"""Chooses where a robot drives to see the tape of a floor that it has not seen yet.

The next best view (Connolly 1985). What is to be seen first is the floor inside the hull of the
tape that is known, and the floor beyond the ends of strokes (as frontiers, Yamauchi 1997), from
places in between that tape. Floor that other tape hid from the camera was not seen. Afterwards the
robot looks outward, around the whole hull, as far as it sees: there may be tape that does not touch
this one. For that it goes a little beyond the tape, on floor that it has seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from robot.driving.route import Route
from robot.fields.occupancy_grid import UNKNOWN, OccupancyGrid
from robot.geometry import Array, Pose2, wrap_angle
from robot.mapping.sketch import Sketch

CELL = 0.05
"""Side of a cell of floor that is seen or not [m]."""
NEAREST, FARTHEST = 0.10, 0.55
"""From the robot's origin, floor is seen well between these distances [m]."""
BLIND = 0.16
"""Rays begin this far from it; tape that is nearer hides nothing [m]."""
HALF_ANGLE = math.radians(26)
"""... and to this angle from straight ahead [rad]."""
SPACING = 0.12
"""Distance of the places that views are chosen from [m]."""
HEADINGS = 12
"""Headings in which a place may be looked from: one each 30 degrees; a view is 52 degrees wide."""
INSIDE = 0.10
"""Views are this far within the hull of the tape [m], so that a robot at one is still within it."""
OUTSIDE = 0.15
"""... but, to look outward, may lie this far outside it [m]: fields have as much floor beyond their
tape, and a robot that looks from the inner side of tape sees 0.1 m less far."""
NEAR, RING, RING_CELL = 0.75, 0.95, 0.10
"""From and up to how far outside the hull the floor around it is looked at, in cells of a side [m]:
what is nearer is in the same pictures."""
FARTHEST_OUTWARD = 0.82
"""A robot finds tape that it faces up to this far ahead [m]."""
OUTWARD_GAIN = 3.0
"""A view outward that shows fewer new cells of that size is not worth the way."""
MOST_LOOKS = 3
"""Floor that this many views should have shown, and did not, is left: something hides it."""
CHECKED = 40
"""Of so many of the best views it is asked what tape hides from them."""
BEYOND = 0.12
"""The tape may go on this far beyond the end of a stroke [m]."""
END_WEIGHT = 4.0
"""How many cells a cell at the end of a stroke is worth."""
LEAST_GAIN = 6.0
"""A view that shows fewer new cells is not worth the way."""
WAY_COST, TURN_COST, FIXED_COST = 2.0, 0.15, 0.4
"""What a view costs: by its distance [1/m], by turns [1/rad], and in any case."""
WITHOUT_TAPE = 0.4
"""Worth of a view that shows no known tape: only the wheels tell where the robot is there."""
BACK = 0.05
"""The robot is back if it stands this near to where the map began [m]."""


class Explorer:
    """Chooses the routes of one drive, one after the other."""

    def __init__(self) -> None:
        """Begin where nothing was looked at."""
        self._visited: list[Array] = []
        self._returned = False
        self.hidden = np.zeros((0, 2))
        """(n, 2) places that no view has shown, though it should have, at the end [m]."""

    def next(
        self, sketch: Sketch | None, pose: Pose2, looked: OccupancyGrid | None = None
    ) -> Route | None:
        """Return the next route in the frame of the map; None if there is nothing left to see.

        The first is a turn on the spot, the last leads back to where the map began.

        Args:
            sketch: the map so far; None if there is none.
            pose: of the robot in it, standing.
            looked: the map in cells; those that nobody saw are unknown. Without, all that was in
                view counts as seen.
        """
        begins = not self._visited
        # The map may not have the picture from here yet, as it takes some at a time.
        self._visited.append(pose.to_array())
        if begins:
            return Route(pose, turn=math.tau)
        if sketch is None:
            return None
        visited = np.array(self._visited)
        view = best_view(sketch, visited, pose, looked)
        if view is None:
            view = best_view(sketch, visited, pose, looked, outward=True)
        if view is not None:
            self._returned = False
            return Route(view)
        start = Pose2.from_array(sketch.path[0])
        if self._returned or pose.distance_to(start) < BACK:
            return None
        self._returned = True
        self.hidden = _hidden(sketch, visited, looked)
        return Route(start)


def best_view(
    sketch: Sketch,
    visited: Array,
    pose: Pose2,
    looked: OccupancyGrid | None = None,
    *,
    outward: bool = False,
) -> Pose2 | None:
    """Return the pose from which most can be seen that is new, for its way; None if nothing can.

    Args:
        sketch: the map so far.
        visited: (k, 3) poses that the robot looked from, besides those of the map [m, m, rad].
        pose: of the robot.
        looked: the map in cells; those that nobody saw are unknown.
        outward: whether the floor around the tape is to be seen, not that between it.
    """
    tape = np.vstack([np.vstack(sketch.lines), sketch.edges]) if sketch.lines else sketch.edges
    inside = _Hull.of(tape)
    if inside is None:
        return None
    farthest, least = (FARTHEST_OUTWARD, OUTWARD_GAIN) if outward else (FARTHEST, LEAST_GAIN)
    if outward:
        cells = inside.ring()
        worth = np.ones(len(cells))
    else:
        cells, worth = _wanted(sketch, inside)
    path = np.vstack([sketch.path, visited])
    unseen = ~_seen(cells, path, looked, farthest) & ~_left(cells, visited, farthest)
    cells, worth = cells[unseen], worth[unseen]
    if worth.sum() < least:
        return None
    views = _views(inside, tape, looked, outward=outward)
    shows = _in_view(cells, views, farthest)
    shows_tape = _in_view(_thinned(tape), views, FARTHEST).sum(axis=1) >= 3
    factor = np.where(shows_tape, 1.0, WITHOUT_TAPE)
    away = views[:, :2] - (pose.x, pose.y)
    distance = np.hypot(*away.T)
    first = np.arctan2(away[:, 1], away[:, 0])
    turns = np.abs(wrap_angle(first - pose.theta)) + np.abs(wrap_angle(views[:, 2] - first))
    factor /= FIXED_COST + WAY_COST * distance + TURN_COST * turns
    hopes = factor * (shows @ worth)
    segments = _segments(sketch)
    best, most = None, 0.0
    # What is promised is an upper bound of what tape leaves of it.
    for view in np.argsort(-hopes, kind="stable")[:CHECKED]:
        if hopes[view] <= most:
            break
        shown = shows[view].copy()
        shown[shown] = ~_behind(views[view], cells[shown], segments)
        gain = float(worth[shown].sum())
        if gain >= least and factor[view] * gain > most:
            best, most = views[view], factor[view] * gain
    return None if best is None else Pose2.from_array(best)


@dataclass(frozen=True, eq=False)
class _Hull:
    """The convex hull of tape."""

    planes: Array
    """(h, 3) outward normals and offsets [m]."""
    corners: Array
    """(h, 2) in order, anticlockwise [m]."""
    low: Array
    high: Array
    """(2,) its extent [m]."""

    @classmethod
    def of(cls, points: Array) -> _Hull | None:
        try:
            hull = ConvexHull(points)
        except (QhullError, ValueError):
            return None  # fewer than three points, or all on a line
        corners = points[hull.vertices]
        return cls(hull.equations, corners, points.min(axis=0), points.max(axis=0))

    def depth(self, points: Array) -> Array:
        """Return how far points (n, 2) lie inside (n,) [m]; negative outside."""
        depth: Array = -(points @ self.planes[:, :2].T + self.planes[:, 2]).max(axis=1)
        return depth

    def grid(self, step: float, depth: float) -> Array:
        """Return points (n, 2) on a grid that lie at least a depth inside [m]."""
        axes = [np.arange(a, b + step, step) for a, b in zip(self.low, self.high, strict=True)]
        points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        inside: Array = points[self.depth(points) >= depth]
        return inside

    def around(self, step: float) -> Array:
        """Return places (n, 2) along its border: outside, on it, and inside, about a step apart."""
        corners = self.corners
        edges = np.diff(np.vstack([corners, corners[:1]]), axis=0)
        places = []
        for corner, edge in zip(corners, edges, strict=True):
            length = math.hypot(*edge)
            outward = np.array([edge[1], -edge[0]]) / length
            along = corner + np.linspace(0, 1, 2 + round(length / step))[:, None] * edge
            places += [along + aside * outward for aside in (OUTSIDE, 0.0, -INSIDE)]
        return np.vstack(places)

    def ring(self) -> Array:
        """Return the middles of cells (n, 2) around it, near enough to be seen."""
        axes = [
            np.arange(a - RING, b + RING, RING_CELL)
            for a, b in zip(self.low, self.high, strict=True)
        ]
        points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        # Beyond a hull's corner this is nearer than the hull.
        depth = self.depth(points)
        around: Array = points[(depth < -NEAR) & (depth > -RING)]
        return around


def _wanted(sketch: Sketch, inside: _Hull) -> tuple[Array, Array]:
    """Return the cells (n, 2) to be seen, and what each is worth (n,)."""
    floor = inside.grid(CELL, 0.0)
    beyond = [floor[:0]]
    for line in sketch.lines:
        if math.dist(line[0], line[-1]) < CELL:
            continue  # closed
        for end, before in ((line[0], line[1]), (line[-1], line[-2])):
            outward = (end - before) / max(1e-9, math.dist(end, before))
            beyond.append(end + np.array([[CELL / 2], [BEYOND]]) * outward)
    ends = np.vstack(beyond)
    worth = np.concatenate([np.ones(len(floor)), np.full(len(ends), END_WEIGHT)])
    return np.vstack([floor, ends]), worth


def _views(inside: _Hull, tape: Array, looked: OccupancyGrid | None, *, outward: bool) -> Array:
    """Return the poses (v, 3) that are considered."""
    if outward:
        places = inside.around(SPACING)
        # Nobody knows whether the floor goes on where the camera has not looked.
        places = places[
            (inside.depth(places) >= 0.0) | ((looked is not None) & _known(places, looked))
        ]
    else:
        places = inside.grid(SPACING, INSIDE)
    if not len(places):
        places = np.array([tape.mean(axis=0)])
    headings = np.arange(HEADINGS) * math.tau / HEADINGS - math.pi
    return np.column_stack([np.repeat(places, HEADINGS, axis=0), np.tile(headings, len(places))])


def _hidden(sketch: Sketch, visited: Array, looked: OccupancyGrid | None) -> Array:
    """Return places (n, 2) between the tape and at its ends that were not seen."""
    tape = np.vstack([np.vstack(sketch.lines), sketch.edges]) if sketch.lines else sketch.edges
    inside = _Hull.of(tape)
    if inside is None:
        return np.zeros((0, 2))
    cells, worth = _wanted(sketch, inside)
    unseen = ~_seen(cells, np.vstack([sketch.path, visited]), looked, FARTHEST)
    if worth[unseen].sum() < LEAST_GAIN:
        return np.zeros((0, 2))
    # One for each place as large as a view that is worth its way.
    coarse = math.sqrt(LEAST_GAIN) * CELL
    _, first, sizes = np.unique(
        np.floor(cells[unseen] / coarse), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(cells[unseen][first[np.argsort(-sizes, kind="stable")]])


def _known(points: Array, looked: OccupancyGrid | None) -> NDArray[np.bool_]:
    """Return which points (n, 2) lie on tape, or on floor that was seen."""
    if looked is None:
        return np.ones(len(points), bool)
    known: NDArray[np.bool_] = looked.values_at(points) != UNKNOWN
    return known


def _seen(
    cells: Array, path: Array, looked: OccupancyGrid | None, farthest: float
) -> NDArray[np.bool_]:
    """Return which cells (n,) were seen from any pose of the path (k, 3)."""
    seen = np.zeros(len(cells), bool)
    for start in range(0, len(path), 200):
        seen |= _in_view(cells, path[start : start + 200], farthest).any(axis=0)
    return seen & _known(cells, looked)


def _left(cells: Array, visited: Array, farthest: float) -> NDArray[np.bool_]:
    """Return which cells (n,) enough views (k, 3) should have shown."""
    tried: NDArray[np.bool_] = _in_view(cells, visited, farthest).sum(axis=0) >= MOST_LOOKS
    return tried


def _segments(sketch: Sketch) -> Array:
    """Return the tape that is known as segments (m, 2, 2) [m]."""
    lines = [np.stack([line[:-1], line[1:]], axis=1) for line in sketch.lines]
    return np.concatenate([np.zeros((0, 2, 2)), *lines])


def _behind(view: Array, cells: Array, segments: Array) -> NDArray[np.bool_]:
    """Return which cells (n,) tape hides from a view (3,): rays end at the first tape they meet."""
    place = view[:2]
    start, way = segments[:, 0] - place, segments[:, 1] - segments[:, 0]
    ray = cells - place
    with np.errstate(divide="ignore", invalid="ignore"):
        cross = ray[:, :1] * way[:, 1] - ray[:, 1:] * way[:, 0]
        part = (start[:, 0] * way[:, 1] - start[:, 1] * way[:, 0]) / cross
        along = (start[:, 0] * ray[:, 1:] - start[:, 1] * ray[:, :1]) / cross
    # Tape that is nearer than rays begin hides nothing.
    near = BLIND / np.hypot(*ray.T)[:, None]
    behind = (part > near) & (part < 1) & (along >= 0) & (along <= 1)
    hidden: NDArray[np.bool_] = behind.any(axis=1)
    return hidden


def _in_view(points: Array, poses: Array, farthest: float) -> NDArray[np.bool_]:
    """Return which points (n, 2) are in view from poses (v, 3), as (v, n)."""
    away = points - poses[:, None, :2]
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    ahead = c * away[..., 0] + s * away[..., 1]
    left = c * away[..., 1] - s * away[..., 0]
    distance = np.hypot(ahead, left)
    in_view: NDArray[np.bool_] = (
        (distance > NEAREST) & (distance < farthest) & (np.abs(left) < math.tan(HALF_ANGLE) * ahead)
    )
    return in_view


def _thinned(tape: Array) -> Array:
    """Return one point (n, 2) for each cell that has tape."""
    _, kept = np.unique(np.floor(tape / CELL), axis=0, return_index=True)
    thin: Array = tape[np.sort(kept)]
    return thin
