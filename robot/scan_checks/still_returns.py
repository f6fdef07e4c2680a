"""Finds returns that travel with the robot: the shadow of its own mast, a cable, a dirty lens.

Neighbouring returns lie along an edge. While the robot moves, tape on the floor comes nearer by
what odometry says of the way across that edge; what travels with the robot does not. If all returns
stay where they are, the robot stands and its wheels turn, so others must have moved meanwhile.

What half and twice of a constant change is of the returns of a shadow on laps of *stub*, *town* and
*square*: usually 89.7 % of them are found, and 12 returns of tape are taken for it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array, Pose2
from robot.scan import Scan

Rays = NDArray[np.bool_]

SAME = 0.004
"""A return within this of where it was has stayed there [m]; a nearer one may hide it. Half: 85.1 %
are found; twice: 90.6, and 150 are wrong."""
HIDDEN = 45
"""In so many pictures a return may be hidden before another one takes its place. What travels with
the robot may be hidden for long. Half: 90.1 % are found, and 20 wrong; twice: 87.5 and 11."""
GONE, BACK = 90, 4
"""It is gone after so many pictures that see past it; each that sees it makes up for ``BACK``.
Half and twice of ``GONE``: as many are found, and 12 and 14 wrong."""
BESIDE = 3
"""The edge's direction at a return is that from this many rays before it to as many after. Half and
twice: nothing changes beyond chance."""
APART = 0.05
"""Returns of neighbouring rays farther apart than this do not lie along one edge [m]. Half and
twice: nothing changes."""
ACROSS, ACROSS_SHARE = 0.03, 0.15
"""Way across its edge on which a return must have stayed [m], and share of the whole way: along
tape, the errors of an edge's direction add up. Half of the way: 90.8 % are found, and 18 wrong;
twice: 86.7 and 5. Half and twice of the share: 89.8 and 89.4 %."""
STRIDE, ARM = 0.015, 0.1
"""Returns are compared over this way [m]; a turn counts as a way of ``ARM`` for each radian.
Half and twice of either: 89.5 to 90.1 % are found, and 12 wrong."""
REACH = 0.6
"""Returns within this are exact enough to show that the floor moves [m]. Half and twice: nothing
changes."""
MOVED = 3
"""In so many strides some must have moved. Half: 90.1 % are found; twice: 89.3."""
FEWEST = 6
"""Fewer neighbouring rays than this may stay, or move, by chance. Half: 90.0 % are found; twice:
89.1."""
LONGEST = 1.0
"""After a longer time, or one that runs back, as in a replay, nothing is known [s]."""


class FollowedRays(NamedTuple):
    """What is remembered of each of k rays."""

    range: Array
    """Where its return was first seen [m]; inf without one."""
    known: Rays
    """Whether that travels with the robot."""
    missed: NDArray[np.int64]
    """In how many pictures it was missed."""
    since: NDArray[np.int64]
    """How often others had moved when it came to be there."""
    way: Array
    """Way of the robot since then [m]."""
    seen_way: Array
    """Way while it was seen [m]."""
    across: Array
    """Part of that way across the edge there [m]."""


class StillReturns:
    """Remembers of each ray since when its return has been where it is."""

    def __init__(self) -> None:
        """Begin with nothing known."""
        self._begin(np.empty(0))
        self._last: Pose2 | None = None
        self._stamp = -math.inf
        self._stride = 0.0
        """Way since returns were last compared [m]."""
        self._moves = 0
        """In how many strides some of them have moved."""

    def _begin(self, bearings: Array) -> None:
        rays = len(bearings)
        self._bearings = bearings
        self._compared: Array = np.full(rays, np.inf)
        """Range of each ray when returns were last compared [m]."""
        self._followed = FollowedRays(
            np.full(rays, np.inf),
            np.zeros(rays, bool),
            *np.zeros((2, rays), np.int64),
            *np.zeros((3, rays)),
        )

    def find(self, scan: Scan, odometry: Pose2) -> Rays:
        """Return which rays (k,) of a scan returned something that travels with the robot.

        Args:
            scan: a scan soon after the last one, with its bearings; else it begins again.
            odometry: the robot in the odom frame at the scan's stamp.
        """
        elapsed, self._stamp = scan.stamp - self._stamp, scan.stamp
        same_rays = scan.bearings is self._bearings or np.array_equal(scan.bearings, self._bearings)
        if not (0 < elapsed < LONGEST and same_rays):
            self._begin(scan.bearings)
            self._last = None
        if len(scan.bearings) < FEWEST + BESIDE:
            return np.zeros(len(scan.bearings), bool)
        step = Pose2() if self._last is None else self._last.inverse() @ odometry
        self._last = odometry
        self._compare(scan, step)
        start, back = scan.robot_from_scan, step.inverse()
        rays = np.stack([scan.ranges, scan.bearings])
        still: Rays = _follow(
            self._followed,
            rays,
            (start.x, start.y, start.theta),
            (back.x, back.y, back.theta),
            self._moves,
        )
        return still

    def _compare(self, scan: Scan, step: Pose2) -> None:
        """Count the returns that have moved in the last stride."""
        self._stride += math.hypot(step.x, step.y) + ARM * abs(step.theta)
        if self._stride > STRIDE:
            self._stride = 0.0
            near = np.minimum(scan.ranges, self._compared) < REACH
            both = near & np.isfinite(self._compared) & scan.hit & ~self._followed.known
            offsets = scan.ranges[both] - self._compared[both]
            self._moves += int(np.count_nonzero(np.abs(offsets) > SAME) >= FEWEST)
            self._compared = scan.ranges


@compiled()
def _follow(
    followed: FollowedRays,
    rays: Array,
    start: tuple[float, float, float],
    back: tuple[float, float, float],
    moves: int,
) -> Rays:
    """Update what is remembered; return which returns (k,) travel with the robot.

    Args:
        followed: what is remembered of each ray.
        rays: range [m] and bearing [rad] of each (2, k).
        start: where rays begin in the robot's frame [m], [rad].
        back: the motion since the last scan, undone [m], [rad].
        moves: how often others have moved.
    """
    count, way = rays.shape[1], math.hypot(back[0], back[1])
    stayed, ends = np.zeros(count, np.bool_), np.empty((count, 2))
    for ray in range(count):
        ends[ray, 0] = ends[ray, 1] = np.nan
        stayed[ray] = _stays(followed, ray, rays[0, ray], moves)
        followed.way[ray] += way
        if stayed[ray]:
            followed.seen_way[ray] += way
            heading = start[2] + rays[1, ray]
            ends[ray, 0] = start[0] + math.cos(heading) * followed.range[ray]
            ends[ray, 1] = start[1] + math.sin(heading) * followed.range[ray]
    stays, moved = followed.known.copy(), followed.known.copy()
    for ray in range(count):
        if stayed[ray]:
            if BESIDE <= ray < count - BESIDE:
                edge_x = ends[ray + BESIDE, 0] - ends[ray - BESIDE, 0]
                edge_y = ends[ray + BESIDE, 1] - ends[ray - BESIDE, 1]
                followed.across[ray] += _moved_across(ends[ray], (edge_x, edge_y), back)
            if abs(followed.across[ray]) > ACROSS + ACROSS_SHARE * followed.way[ray]:
                stays[ray] = True
                moved[ray] |= moves - followed.since[ray] >= MOVED
    known, still = np.zeros(count, np.bool_), np.zeros(count, np.bool_)
    _mark_rows(known, moved, moved, FEWEST)
    # What lies in one row with it belongs to it, and its ends, where no edge has a direction.
    _mark_rows(known, stays, known.copy(), 1)
    for ray in range(count):
        near = False
        for beside in range(max(ray - BESIDE, 0), min(ray + BESIDE + 1, count)):
            near |= known[beside]
        end = near and stayed[ray] and followed.seen_way[ray] > ACROSS
        followed.known[ray] = known[ray] or end
        still[ray] = stayed[ray] and followed.known[ray]
    return still


@compiled()
def _stays(followed: FollowedRays, ray: int, distance: float, moves: int) -> bool:
    """Whether a ray's return is where it was; otherwise count that, or begin anew with it."""
    before, known = followed.range[ray], followed.known[ray]
    offset = distance - before if math.isfinite(distance) else np.inf
    seen = math.isfinite(before)
    if seen and abs(offset) < SAME:
        followed.missed[ray] = max(followed.missed[ray] - BACK, 0) if known else 0
        return True
    nearer = seen and offset < -SAME
    if not (nearer and known):
        followed.missed[ray] += 1
    patience = GONE if known else HIDDEN if nearer else 0
    if followed.missed[ray] > patience:
        followed.range[ray] = distance
        followed.known[ray] = False
        followed.missed[ray], followed.since[ray] = 0, moves
        followed.way[ray] = followed.seen_way[ray] = followed.across[ray] = 0.0
    return False


@compiled()
def _moved_across(end: Array, edge: tuple[float, float], back: tuple[float, float, float]) -> float:
    """Return how far tape at a return would have moved across its edge [m]; 0 if unknown."""
    length = math.hypot(edge[0], edge[1])
    if not 0.0 < length < 2 * BESIDE * APART:  # nor where one has no return
        return 0.0
    c, s = math.cos(back[2]), math.sin(back[2])
    flow_x = back[0] + c * end[0] - s * end[1] - end[0]
    flow_y = back[1] + s * end[0] + c * end[1] - end[1]
    return float((edge[0] * flow_y - edge[1] * flow_x) / length)


@compiled()
def _mark_rows(marked: Rays, rays: Rays, some: Rays, fewest: int) -> None:
    """Mark the rows of so many neighbouring rays that have at least one of some others."""
    first, with_some = 0, False
    for end in range(len(rays) + 1):
        if end < len(rays) and rays[end]:
            with_some |= some[end]
            continue
        if with_some and end - first >= fewest:
            for ray in range(first, end):
                marked[ray] = True
        first, with_some = end + 1, False
