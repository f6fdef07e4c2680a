"""Chooses where a robot drives to see the tape of a floor that it has not seen yet.

The next best view (Connolly 1985). What is to be seen first is the floor inside the hull of the
tape that is known, and the floor beyond the ends of strokes (as frontiers, Yamauchi 1997). Floor
that tape hid from the camera was not seen. Afterwards the robot goes around the hull and looks
outward as far as it sees: there may be tape that does not touch this one. For that it leaves the
tape a little, on floor that it has seen.

It comes to an end: each look settles at least the least gain of what is wanted, as what could have
been seen from there is not wanted again, whether it was seen or not. What was not is told.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError, cKDTree

from robot.driving.route import Route
from robot.fields.occupancy_grid import UNKNOWN, OccupancyGrid
from robot.geometry import Array, Pose2, wrap_angle
from robot.mapping.sketch import Sketch

CELL = 0.05
"""Side of a cell of floor that is seen or not [m]."""
NEAREST, FARTHEST = 0.10, 0.55
"""From the robot's origin, floor is seen well between these distances [m]."""
BLIND = 0.16
"""Rays begin this far from it; tape that is nearer hides nothing [m]. Half: the same drives; twice:
13 to 27 % longer on a square and in three rooms in a row."""
HALF_ANGLE = math.radians(26)
"""... and to this angle from straight ahead [rad]."""
SPACING = 0.12
"""Distance of the places that views are chosen from [m]."""
HEADINGS = 12
"""Headings in which a place may be looked from: one each 30 degrees; a view is 52 degrees wide."""
INSIDE = 0.10
"""Views are this far within the hull of the tape [m], so that a robot at one is still within it."""
BESIDE = 0.06
"""Floor that is nearer to the middle of tape was seen with it [m]. Half: up to 4 % longer drives;
twice: up to 4 % shorter ones, and as much tape."""
OUTSIDE = 0.20
"""To look outward, the robot may be this far outside the hull [m]: fields have as much floor beyond
their tape, and what is a metre off is out of sight from the tape itself. With 0.11, 1 % of an
island 1 m off was missed; with 0.44 drives were 11 to 34 % longer, on floor that fields need not
have."""
RING, RING_CELL = (0.30, 1.00), 0.10
"""The floor around the hull, from and up to how far, is looked at in cells of a side [m].
Half the side: drives of 11 to 66 % more, and no more tape; twice the side, or a ring from 0.15 to
0.5 m: an island a metre off is not found."""
OUTWARD = 0.82
"""A robot finds tape up to this far ahead [m]. Half or twice: an island 1 m off was not found, as
it did not go to where it would have seen it."""
OUTWARD_GAIN = 16.0
"""A look outward that shows fewer new cells of that size is not worth the way. With 5 the drive on
a square took 97 s, with 10 it took 77, with 20 it took 70, and the same tape was found."""
BEYOND = 0.12
"""The tape may go on this far beyond the end of a stroke [m]."""
END_WEIGHT = 4.0
"""How many cells a cell at the end of a stroke is worth."""
LEAST_GAIN = 6.0
"""A view that shows fewer new cells is not worth the way."""
MOST_LOOKS = 400
"""After so many looks, the robot returns: a map that changes with each look would never end.
Half and twice: no drive changes, as 14 to 77 routes were driven in 30 generated fields."""
CHECKED = 40
"""Of so many of the best views it is asked what tape hides from them. Half or twice: the same
drives."""
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
        self._lookouts: list[Array] = []
        self._sweep: Route | None = None
        self._returned = False
        self.unseen = np.zeros((0, 2))
        """(n, 2) places between and around the tape that were not seen, at the end [m]."""

    @property
    def waits(self) -> bool:
        """Whether the next route depends on what was seen on the last one."""
        return self._sweep is None

    def next(
        self, sketch: Sketch | None, pose: Pose2, looked: OccupancyGrid | None
    ) -> Route | None:
        """Return the next route in the frame of the map; None if there is nothing left to see.

        The first is a turn on the spot, the last leads back to where the map began.

        Args:
            sketch: the map so far; None if there is none.
            pose: of the robot in it, standing.
            looked: the map in cells; those that nobody saw are unknown.
        """
        begins = not self._visited
        # The map may not have the picture from here yet, as it takes some at a time.
        self._visited.append(pose.to_array())
        if begins:
            return Route(pose, turn=math.tau)
        if self._sweep is not None:
            sweep, self._sweep = self._sweep, None
            return Route(Pose2(pose.x, pose.y, sweep.goal.theta), turn=sweep.turn)
        if sketch is None or looked is None:
            return None
        floor = KnownFloor.of(sketch, looked)
        if floor is not None and len(self._visited) < MOST_LOOKS:
            route = self._inward(floor, pose) or self._outward(floor, pose)
            if route is not None:
                self._returned = False
                return route
        start = Pose2.from_array(sketch.path[0])
        if self._returned or pose.distance_to(start) < BACK:
            self.unseen = self._left(floor)
            return None
        self._returned = True
        return Route(start)

    def _inward(self, floor: KnownFloor, pose: Pose2) -> Route | None:
        view = best_view(floor, np.array(self._visited), pose)
        if view is None:
            return None
        # It will stand a little beside, and see a little less.
        self._visited.append(view.to_array())
        return Route(view)

    def _outward(self, floor: KnownFloor, pose: Pose2) -> Route | None:
        """Return the way to where most around the tape can be seen; it looks around there next."""
        cells = floor.hull.ring()
        cells = cells[~(floor.known(cells) | self._looked_out(floor, cells))]
        best = best_lookout(floor, cells, pose)
        if best is None:
            return None
        place, bearings = best
        self._lookouts.append(place)
        x, y = place.tolist()
        first, turn = _sweep(bearings, math.atan2(place[1] - pose.y, place[0] - pose.x))
        self._sweep = Route(Pose2(x, y, wrap_angle(first + turn)), turn=turn)
        return Route(Pose2(x, y, first))

    def _looked_out(self, floor: KnownFloor, cells: Array) -> NDArray[np.bool_]:
        """Return which cells (n,) should have been seen from where the robot looked around."""
        done = np.zeros(len(cells), bool)
        for place in self._lookouts:
            done |= floor.visible(place, cells)
        return done

    def _left(self, floor: KnownFloor | None) -> Array:
        if floor is None:
            return np.zeros((0, 2))
        cells, worth = floor.wanted()
        unseen = ~floor.known(cells)
        ring = floor.hull.ring()
        ring = ring[~(floor.known(ring) | self._looked_out(floor, ring))]
        between = _large(cells[unseen], worth[unseen], CELL, LEAST_GAIN)
        return np.vstack([between, _large(ring, np.ones(len(ring)), RING_CELL, OUTWARD_GAIN)])


def best_view(floor: KnownFloor, visited: Array, pose: Pose2) -> Pose2 | None:
    """Return the pose from which most can be seen that is new, for its way; None if nothing can.

    Args:
        floor: what is known.
        visited: (k, 3) poses that the robot looked from [m, m, rad].
        pose: of the robot.
    """
    cells, worth = floor.wanted()
    unseen = ~floor.known(cells)
    for looked in visited:
        unseen[unseen] &= ~floor.shown(looked, cells[unseen])
    cells, worth = cells[unseen], worth[unseen]
    if worth.sum() < LEAST_GAIN:
        return None
    views = _views(floor)
    shows = _in_view(cells, views)
    shows_tape = _in_view(_thinned(floor.tape), views).sum(axis=1) >= 3
    factor = np.where(shows_tape, 1.0, WITHOUT_TAPE)
    away = views[:, :2] - (pose.x, pose.y)
    distance = np.hypot(*away.T)
    first = np.arctan2(away[:, 1], away[:, 0])
    turns = np.abs(wrap_angle(first - pose.theta)) + np.abs(wrap_angle(views[:, 2] - first))
    factor /= FIXED_COST + WAY_COST * distance + TURN_COST * turns
    hopes = factor * (shows @ worth)
    best, most = None, 0.0
    # What is promised is an upper bound of what tape leaves of it.
    for view in np.argsort(-hopes, kind="stable")[:CHECKED]:
        if hopes[view] <= most:
            break
        gain = float(worth[floor.shown(views[view], cells)].sum())
        if gain >= LEAST_GAIN and factor[view] * gain > most:
            best, most = views[view], factor[view] * gain
    return None if best is None else Pose2.from_array(best)


def best_lookout(floor: KnownFloor, cells: Array, pose: Pose2) -> tuple[Array, Array] | None:
    """Return the place (2,) around the tape that shows most of some cells (n, 2), for its way.

    Also return in which directions (k,) it shows them [rad]; None if no place shows enough.
    """
    from_place = np.array([pose.x, pose.y])
    best, most = None, 0.0
    # From the outside it sees farther; but for the first time it has to look there from the border.
    for outside in (OUTSIDE, 0.0):
        for place in floor.within_reach(floor.hull.around(SPACING, outside), from_place):
            shown = floor.visible(place, cells)
            gain = shown.sum() / (FIXED_COST + WAY_COST * math.dist(place, from_place))
            if shown.sum() >= OUTWARD_GAIN and gain > most:
                away = cells[shown] - place
                best, most = (place, np.arctan2(away[:, 1], away[:, 0])), gain
        if best is not None:
            break
    return best


def _sweep(bearings: Array, arrival: float) -> tuple[float, float]:
    """Return the first heading and the turn that show all bearings (n,) [rad]; the nearer first."""
    ordered = np.sort(bearings)
    gaps = np.diff(ordered, append=ordered[0] + math.tau)
    widest = int(np.argmax(gaps))
    turn = max(0.0, math.tau - float(gaps[widest]) - HALF_ANGLE)
    first = wrap_angle(float(ordered[(widest + 1) % len(ordered)]) + HALF_ANGLE / 2)
    if abs(wrap_angle(first + turn - arrival)) < abs(wrap_angle(first - arrival)):
        return wrap_angle(first + turn), -turn
    return first, turn


def _large(cells: Array, worth: Array, side: float, least: float) -> Array:
    """Return places (k, 2) around which cells (n, 2) of a side [m] are worth it, wherever they lie.

    They are counted in squares about each cell: on a fixed grid, a patch on a border would be two
    halves, neither of which is told.
    """
    if not len(cells):
        return cells
    reach = math.ceil(math.sqrt(least)) * side / 2
    places: list[Array] = []
    tree, free = cKDTree(cells), np.ones(len(cells), bool)
    sums = np.array([worth[near].sum() for near in tree.query_ball_point(cells, reach, p=np.inf)])
    for cell in np.argsort(-sums, kind="stable"):
        if sums[cell] >= least and free[cell]:
            places.append(cells[cell])
            free[tree.query_ball_point(cells[cell], 2 * reach, p=np.inf)] = False
    return np.array(places).reshape(-1, 2)


@dataclass(frozen=True, eq=False)
class _Hull:
    """The convex hull of tape."""

    planes: Array
    """(h, 3) outward normals and offsets [m]."""
    corners: Array
    """(h, 2) in order, anticlockwise [m]."""

    @classmethod
    def of(cls, points: Array) -> _Hull | None:
        try:
            hull = ConvexHull(points)
        except (QhullError, ValueError):
            return None  # fewer than three points, or all on a line
        return cls(hull.equations, points[hull.vertices])

    def depth(self, points: Array) -> Array:
        """Return how far points (..., 2) lie inside (...) [m]; negative outside."""
        depth: Array = -(points @ self.planes[:, :2].T + self.planes[:, 2]).max(axis=-1)
        return depth

    def grid(self, step: float, depth: float) -> Array:
        """Return points (n, 2) on a grid that lie at least a depth inside [m], or outside it.

        They stay where they are while the hull grows.
        """
        margin = max(0.0, -depth)
        low = np.floor((self.corners.min(axis=0) - margin) / step)
        high = np.ceil((self.corners.max(axis=0) + margin) / step)
        axes = [step * np.arange(a, b + 1) for a, b in zip(low, high, strict=True)]
        points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        inside: Array = points[self.depth(points) >= depth]
        return inside

    def around(self, step: float, outside: float) -> Array:
        """Return places (n, 2) along its border, so far outside, about a step apart [m]."""
        places = []
        for corner, after in zip(self.corners, np.roll(self.corners, -1, axis=0), strict=True):
            edge = after - corner
            length = math.hypot(*edge)
            outward = np.array([edge[1], -edge[0]]) / length
            along = corner + np.linspace(0, 1, 2 + round(length / step))[:, None] * edge
            places.append(along + outside * outward)
        return np.vstack(places)

    def ring(self) -> Array:
        """Return the middles of cells (n, 2) around it, as far as it is looked around."""
        nearest, farthest = RING
        cells = self.grid(RING_CELL, -farthest)
        # Beyond a corner of a hull its sides are nearer than the hull itself.
        around = shapely.distance(shapely.Polygon(self.corners), shapely.points(cells))
        ring: Array = cells[(around > nearest) & (around < farthest)]
        return ring


@dataclass(frozen=True, eq=False)
class KnownFloor:
    """What is known of the floor."""

    hull: _Hull
    tape: Array
    """(n, 2) points at tape [m]."""
    lines: tuple[Array, ...]
    segments: Array
    """(m, 2, 2) the middle of tape [m]."""
    looked: OccupancyGrid

    @classmethod
    def of(cls, sketch: Sketch, looked: OccupancyGrid) -> KnownFloor | None:
        """Return what a sketch shows; None if its tape has no inside."""
        tape = np.vstack([*sketch.lines, sketch.edges])
        hull = _Hull.of(tape)
        if hull is None and len(tape):
            # A single straight line has no inside, but floor around it.
            aside = np.array([BESIDE, -BESIDE])
            hull = _Hull.of(np.vstack([tape + aside, tape - aside]))
        if hull is None:
            return None
        thin = [_without_bends(line) for line in sketch.lines]
        segments = [np.stack([line[:-1], line[1:]], axis=1) for line in thin]
        return cls(
            hull, tape, sketch.lines, np.concatenate([np.zeros((0, 2, 2)), *segments]), looked
        )

    def known(self, points: Array) -> NDArray[np.bool_]:
        """Return which points (..., 2) lie on tape, or on floor that was seen."""
        known: NDArray[np.bool_] = self.looked.values_at(points.reshape(-1, 2)) != UNKNOWN
        return known.reshape(points.shape[:-1])

    def within_reach(self, places: Array, from_place: Array) -> Array:
        """Return the places (n, 2) to which the way from another (2,) is on floor that was seen.

        Within the hull it need not have been. Elsewhere, nobody knows whether floor goes on.
        """
        ways = from_place + np.linspace(0, 1, 20)[:, None, None] * (places - from_place)
        on_floor = (self.hull.depth(ways) >= 0) | self.known(ways)
        reached: Array = places[on_floor.all(axis=0)]
        return reached

    def wanted(self) -> tuple[Array, Array]:
        """Return the cells (n, 2) to be seen, and what each is worth (n,)."""
        floor = self.hull.grid(CELL, 0.0)
        floor = floor[cKDTree(self.tape).query(floor, distance_upper_bound=BESIDE)[0] > BESIDE]
        beyond = [floor[:0]]
        for line in self.lines:
            if math.dist(line[0], line[-1]) < CELL:
                continue  # closed
            for end, before in ((line[0], line[1]), (line[-1], line[-2])):
                outward = (end - before) / max(1e-9, math.dist(end, before))
                beyond.append(end + np.array([[BESIDE], [BEYOND]]) * outward)
        ends = np.vstack(beyond)
        worth = np.concatenate([np.ones(len(floor)), np.full(len(ends), END_WEIGHT)])
        return np.vstack([floor, ends]), worth

    def shown(self, view: Array, points: Array) -> NDArray[np.bool_]:
        """Return which points (n, 2) a view (3,) shows."""
        shown: NDArray[np.bool_] = _in_view(points, view[None])[0]
        shown[shown] = ~self._hidden(view[:2], points[shown])
        return shown

    def visible(self, place: Array, points: Array) -> NDArray[np.bool_]:
        """Return which points (n, 2) a robot sees that looks all around at a place (2,)."""
        distance = np.hypot(*(points - place).T)
        visible: NDArray[np.bool_] = (distance > BLIND) & (distance < OUTWARD)
        visible[visible] = ~self._hidden(place, points[visible])
        return visible

    def _hidden(self, place: Array, points: Array) -> NDArray[np.bool_]:
        """Return which points (n, 2) tape hides: rays end at the first tape that they meet."""
        start, way = self.segments[:, 0] - place, self.segments[:, 1] - self.segments[:, 0]
        ray = points - place
        with np.errstate(divide="ignore", invalid="ignore"):
            cross = ray[:, :1] * way[:, 1] - ray[:, 1:] * way[:, 0]
            part = (start[:, 0] * way[:, 1] - start[:, 1] * way[:, 0]) / cross
            along = (start[:, 0] * ray[:, 1:] - start[:, 1] * ray[:, :1]) / cross
        near = BLIND / np.hypot(*ray.T)[:, None]
        behind = (part > near) & (part < 1) & (along >= 0) & (along <= 1)
        hidden: NDArray[np.bool_] = behind.any(axis=1)
        return hidden


def _without_bends(line: Array) -> Array:
    """Return a line (m, 2) with the points that it needs for a centimetre."""
    simple: Array = shapely.get_coordinates(shapely.simplify(shapely.LineString(line), 0.01))
    return simple


def _views(floor: KnownFloor) -> Array:
    """Return the poses (v, 3) that are considered."""
    places = floor.hull.grid(SPACING, INSIDE)
    if not len(places):
        places = np.array([floor.tape.mean(axis=0)])
    headings = np.arange(HEADINGS) * math.tau / HEADINGS - math.pi
    return np.column_stack([np.repeat(places, HEADINGS, axis=0), np.tile(headings, len(places))])


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
