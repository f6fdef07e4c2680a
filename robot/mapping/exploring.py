"""Chooses where a robot drives to see the tape of a floor that it has not seen yet.

The next best view (Connolly 1985), among views in between the tape that is known: tape is also the
border that the robot stays within. What is to be seen is the floor inside the hull of the tape, and
the floor beyond the ends of strokes (as frontiers, Yamauchi 1997).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from robot.driving.route import Route
from robot.geometry import Array, Pose2, wrap_angle
from robot.mapping.sketch import Sketch

CELL = 0.05
"""Side of a cell of floor that is seen or not [m]."""
NEAREST, FARTHEST = 0.10, 0.55
"""From the robot's origin, floor is seen well between these distances [m]."""
HALF_ANGLE = math.radians(26)
"""... and to this angle from straight ahead [rad]."""
SPACING = 0.12
"""Distance of the places that views are chosen from [m]."""
HEADINGS = 12
"""Headings in which a place may be looked from: one each 30 degrees; a view is 52 degrees wide."""
INSIDE = 0.10
"""Views are this far within the hull of the tape [m], so that a robot at one is still within it."""
BEYOND = 0.12
"""The tape may go on this far beyond the end of a stroke [m]."""
END_WEIGHT = 4.0
"""How many cells a cell at the end of a stroke is worth."""
LEAST_GAIN = 6.0
"""A view that shows fewer new cells is not worth the way."""
WAY_COST, TURN_COST, FIXED_COST = 1.0, 0.15, 0.4
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

    def next(self, sketch: Sketch | None, pose: Pose2) -> Route | None:
        """Return the next route in the frame of the map; None if there is nothing left to see.

        The first is a turn on the spot, the last leads back to where the map began.

        Args:
            sketch: the map so far; None if there is none.
            pose: of the robot in it, standing.
        """
        begins = not self._visited
        # The map may not have the picture from here yet, as it takes some at a time.
        self._visited.append(pose.to_array())
        if begins:
            return Route(pose, turn=math.tau)
        if sketch is None:
            return None
        view = best_view(sketch, np.array(self._visited), pose)
        if view is not None:
            self._returned = False
            return Route(view)
        start = Pose2.from_array(sketch.path[0])
        if self._returned or pose.distance_to(start) < BACK:
            return None
        self._returned = True
        return Route(start)


def best_view(sketch: Sketch, visited: Array, pose: Pose2) -> Pose2 | None:
    """Return the pose from which most can be seen that is new, for its way; None if nothing can.

    Args:
        sketch: the map so far.
        visited: (k, 3) poses that the robot looked from, besides those of the map [m, m, rad].
        pose: of the robot.
    """
    tape = np.vstack([np.vstack(sketch.lines), sketch.edges]) if sketch.lines else sketch.edges
    inside = _Hull.of(tape)
    if inside is None:
        return None
    cells, worth = _wanted(sketch, inside)
    worth = np.where(_seen(cells, np.vstack([sketch.path, visited])), 0.0, worth)
    unseen = worth > 0
    if worth.sum() < LEAST_GAIN:
        return None
    views = _views(inside, tape)
    shows = _in_view(cells[unseen], views)
    gain = shows @ worth[unseen]
    shows_tape = _in_view(_thinned(tape), views).sum(axis=1) >= 3
    enough = gain >= LEAST_GAIN
    gain *= np.where(shows_tape, 1.0, WITHOUT_TAPE)
    away = views[:, :2] - (pose.x, pose.y)
    distance = np.hypot(*away.T)
    first = np.arctan2(away[:, 1], away[:, 0])
    turns = np.abs(wrap_angle(first - pose.theta)) + np.abs(wrap_angle(views[:, 2] - first))
    value = gain / (FIXED_COST + WAY_COST * distance + TURN_COST * turns)
    best = int(np.argmax(np.where(enough, value, 0.0)))
    return Pose2.from_array(views[best]) if enough[best] else None


@dataclass(frozen=True, eq=False)
class _Hull:
    """The convex hull of tape."""

    planes: Array
    """(h, 3) outward normals and offsets [m]."""
    low: Array
    high: Array
    """(2,) its extent [m]."""

    @classmethod
    def of(cls, points: Array) -> _Hull | None:
        try:
            return cls(ConvexHull(points).equations, points.min(axis=0), points.max(axis=0))
        except (QhullError, ValueError):
            return None  # fewer than three points, or all on a line

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


def _views(inside: _Hull, tape: Array) -> Array:
    """Return the poses (v, 3) that are considered."""
    places = inside.grid(SPACING, INSIDE)
    if not len(places):
        places = np.array([tape.mean(axis=0)])
    headings = np.arange(HEADINGS) * math.tau / HEADINGS - math.pi
    return np.column_stack([np.repeat(places, HEADINGS, axis=0), np.tile(headings, len(places))])


def _seen(cells: Array, path: Array) -> NDArray[np.bool_]:
    """Return which cells (n,) were seen from any pose of the path (k, 3)."""
    seen = np.zeros(len(cells), bool)
    for start in range(0, len(path), 200):
        seen |= _in_view(cells, path[start : start + 200]).any(axis=0)
    return seen


def _in_view(points: Array, poses: Array) -> NDArray[np.bool_]:
    """Return which points (n, 2) are in view from poses (v, 3), as (v, n)."""
    away = points - poses[:, None, :2]
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    ahead = c * away[..., 0] + s * away[..., 1]
    left = c * away[..., 1] - s * away[..., 0]
    distance = np.hypot(ahead, left)
    in_view: NDArray[np.bool_] = (
        (distance > NEAREST) & (distance < FARTHEST) & (np.abs(left) < math.tan(HALF_ANGLE) * ahead)
    )
    return in_view


def _thinned(tape: Array) -> Array:
    """Return one point (n, 2) for each cell that has tape."""
    _, kept = np.unique(np.floor(tape / CELL), axis=0, return_index=True)
    thin: Array = tape[np.sort(kept)]
    return thin
