"""``places_seen``: all places on a field at which a robot may be, by what it has seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array, Pose2, heading_vectors
from robot.navigation.free_space import FreeSpace
from robot.navigation.place_kernels import rooms, scores
from robot.scan import Scan

DRAWN, KEPT, WEIGHED = 24_000, 3000, 1000
"""Places that are drawn all over the field, that are followed, and that are returned."""
STAGES = ((0.08, 30.0), (0.05, 14.0), (0.03, 7.0), (0.02, 4.0), (0.012, 2.5))
"""What is seen is compared with the field ever more strictly: standard deviation of a point on tape
[m], and how many points count as one, because their errors are alike."""
OUTLIER = 4.0
"""A point counts against a place by at most this, as a logarithm."""
ON_TAPE = 1.5
"""A point that was seen free counts so much against a place where it lies on tape."""
WITHIN_M = 0.05
"""The robot's middle is at least so far from tape that it does not stand on [m]."""
ROOM_M = 0.003
"""Where it looks around, the robot has come to stand with about this room to tape [m]; where it
began, with its clearance: whoever puts it down, or it itself, leaves as much."""
STOOD_ON_TAPE = 4.0
"""Counts against a place where the robot would stand on tape, or would have stood, as a logarithm:
it was not put there, and has not gone there."""
SAME_VIEW_M, SAME_VIEW_RAD = 0.01, 0.05
"""Views that are nearer to each other say the same."""
RAYS, STEP_M, BEGIN_M, SHORT_M = 23, 0.05, 0.006, 0.03
"""Rays of a view that count, points along them, and from where on, and how far before its end, a
ray is free. With a later begin, tape just in front of the robot was no evidence."""
MOST_POINTS = 1000
"""So many points are compared at each place; if more were seen, every second or third one is."""
INSIDE = 0.8
"""Share of the places that are drawn where robots usually drive; the others, all over the floor."""
MOVED = 2
"""So often each place is moved a little at each stage (Metropolis): so no two are the same."""


@dataclass(frozen=True, eq=False)
class Glimpse:
    """A scan, and where the robot was by its odometry."""

    odom_from_robot: Pose2
    scan: Scan

    def is_elsewhere(self, other: Glimpse) -> bool:
        """Whether the robot stood elsewhere for another view: else both say the same."""
        apart = self.odom_from_robot.distance_to(other.odom_from_robot)
        turned = abs(self.odom_from_robot.turn_to(other.odom_from_robot))
        return apart > SAME_VIEW_M or turned > SAME_VIEW_RAD

    def is_at(self, odom: Pose2) -> bool:
        """Whether it was seen at about a pose in the odometry's frame."""
        return not self.is_elsewhere(replace(self, odom_from_robot=odom))


@dataclass(frozen=True, eq=False)
class _Seen:
    """All that was seen, in the robot's frame now."""

    hits: Array
    clear: Array
    begun: Array
    """(k, 2) points of the outline where it stood for the first view."""
    stood: Array
    """(m, 2) the same for the others, and now."""
    stride: int = 1
    """Each point stands for so many."""

    def thinned(self, most: int) -> _Seen:
        """Return the same with at most about so many points."""
        stride = max(1, math.ceil((len(self.hits) + len(self.clear)) / most))
        return replace(self, hits=self.hits[::stride], clear=self.clear[::stride], stride=stride)

    @classmethod
    def of(cls, views: Sequence[Glimpse], odom: Pose2, rim: Array) -> _Seen:
        hits, clear, stood = [], [], []
        for view in views:
            moved = odom.inverse() @ view.odom_from_robot
            tape, floor = _seen(view.scan)
            hits.append(moved.apply(tape))
            clear.append(moved.apply(floor))
            stood.append(moved.apply(rim))
        return cls(
            np.concatenate(hits),
            np.concatenate(clear),
            stood[0],
            np.concatenate([rim, *(each[::2] for each in stood[1:])]),
        )


def places_seen(
    views: Sequence[Glimpse],
    odom: Pose2,
    marks: FreeSpace,
    free: FreeSpace,
    believed: Sequence[Pose2] = (),
) -> Array:
    """Return places (n, 3) in the map where the robot may be now, all as likely.

    They are drawn all over the field, and chosen by what was seen, ever more strictly (sequential
    Monte Carlo; Del Moral, Doucet and Jasra 2006).

    Args:
        views: what was seen since the place is in doubt; one or more.
        odom: the robot's odometry now.
        marks: distances to all that the robot can see.
        free: distances to what it does not stand on, and its outline.
        believed: poses in the map that a filter holds for possible now.
    """
    # The same for the same views: drives repeat exactly.
    rng = np.random.default_rng(len(views))
    seen = _Seen.of(views, odom, free.hollow.body)
    places = rng.uniform(size=(DRAWN, 3))
    inside = round(INSIDE * DRAWN)
    places[:inside] = _within(places[:inside], free.drive_area)
    places[inside:] = _within(places[inside:], free.extent)
    # The middle of the robot lies inside its outline: it is no wall.
    places = places[free.clearance(places[:, :2]) > WITHIN_M]
    if believed:
        near = np.repeat([pose.to_array() for pose in believed], 20, axis=0)
        places = np.concatenate([places, near + rng.normal(0, (0.01, 0.01, 0.03), near.shape)])
    logs = np.zeros(len(places))
    few = seen.thinned(MOST_POINTS // 4)
    seen = seen.thinned(MOST_POINTS)
    for number, (sd, alike) in enumerate(STAGES):
        # Drawn all over the field there are many places, and few that are near to a good one.
        new = _logs(places, seen if number else few, marks, free, sd, alike)
        places = places[_drawn(new - logs, KEPT, rng)]
        logs = _logs(places, seen, marks, free, sd, alike)
        blur = sd / 3 * np.array([1.0, 1.0, 4.0])
        for _ in range(MOVED):
            tried = places + rng.normal(0, blur, places.shape)
            fresh = _logs(tried, seen, marks, free, sd, alike)
            better = np.log(rng.uniform(size=len(places))) < fresh - logs
            places[better], logs[better] = tried[better], fresh[better]
    return places[rng.permutation(len(places))[:WEIGHED]]


def _logs(
    places: Array, seen: _Seen, marks: FreeSpace, free: FreeSpace, sd: float, alike: float
) -> Array:
    """Return the logarithm of how likely places (n, 3) are, up to a constant."""
    costs = np.array([sd, OUTLIER, ON_TAPE])
    fit: Array = scores(places, seen.hits, seen.clear, marks.distance, marks.frame, costs)
    fit *= seen.stride / alike
    kept = max(free.settings.clearance, ROOM_M)
    for points, needed in ((seen.begun, kept), (seen.stood, ROOM_M)):
        room = rooms(places, points, free.distance, free.frame)
        fit -= STOOD_ON_TAPE * np.clip((needed - room) / ROOM_M, 0.0, 1.0)
    return fit


def _drawn(logs: Array, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """Return indices (count,) drawn by weights, of which logarithms are given, systematically."""
    weights = np.exp(logs - logs.max())
    shares = (np.arange(count) + rng.uniform()) / count
    chosen = np.searchsorted(np.cumsum(weights) / weights.sum(), shares)
    return np.minimum(chosen, len(logs) - 1)


def _within(shares: Array, box: tuple[float, float, float, float]) -> Array:
    """Return places (n, 3) by their shares (n, 3) of a box and of all headings."""
    low, high = np.array([*box[:2], 0.0]), np.array([*box[2:], 2 * math.pi])
    places: Array = low + shares * (high - low)
    return places


def _seen(scan: Scan) -> tuple[Array, Array]:
    """Return the points of a scan that are tape, and those that are free (n, 2) [m].

    What hides a part of a ray is tape, too, as a rule: tape on which the ray begins, or that is
    just before it.
    """
    rays = np.unique(np.linspace(0, len(scan.ranges) - 1, RAYS).round().astype(np.intp))
    some = scan.only(rays)
    sight = some.sight if some.sight is not None else np.tile([0.0, 0.5], (len(rays), 1))
    hidden = some.hidden if some.hidden is not None else np.tile([np.inf, -np.inf], (len(rays), 1))
    tape, clear = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for number, direction in enumerate(heading_vectors(some.bearings)):
        (near, far), distance = sight[number], some.ranges[number]
        if math.isnan(near):
            continue
        begins, ends = hidden[number]
        met = [each for each in (distance, begins, ends) if near <= each < far]
        tape.append(np.array(met)[:, None] * direction)
        # Rays take turns, so that narrow tape does not lie between all points.
        begin = near + BEGIN_M + SHORT_M * (number % 2)
        along = np.arange(begin, min(distance - SHORT_M, far), STEP_M)
        along = along[(along < begins - SHORT_M) | (along > ends + SHORT_M)]
        clear.append(along[:, None] * direction)
    place = some.robot_from_scan
    return place.apply(np.concatenate(tape)), place.apply(np.concatenate(clear))
