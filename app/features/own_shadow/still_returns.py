"""Finds returns that travel with the robot: the shadow of its own mast, a cable, a dirty lens.

Neighbouring returns lie along an edge. While the robot moves, tape on the floor comes nearer by
what odometry says of the way across that edge; what travels with the robot does not. If all returns
stay where they are, the robot stands and its wheels turn, so others must have moved meanwhile.

What half and twice of a constant change is of the returns of a shadow on laps of *stub*, *town* and
*square*: usually 89.7 % of them are found, and 12 returns of tape are taken for it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array, Pose2
from robot.scan import Scan

Rays = NDArray[np.bool_]
Counts = NDArray[np.int64]

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
        self._range: Array = np.full(rays, np.inf)
        """Where each ray's return was first seen [m]."""
        self._seen: Rays = np.zeros(rays, bool)
        """Whether it has one."""
        self._known: Rays = np.zeros(rays, bool)
        """Whether that travels with the robot."""
        self._missed: Counts = np.zeros(rays, np.int64)
        """In how many pictures it was missed."""
        self._since: Counts = np.zeros(rays, np.int64)
        """``_moves`` when it came to be there."""
        self._way: Array = np.zeros(rays)
        """Way of the robot since then [m]."""
        self._seen_way: Array = np.zeros(rays)
        """Way while it was seen [m]."""
        self._across: Array = np.zeros(rays)
        """Part of that way across the edge there [m]."""

    def find(self, scan: Scan, odometry: Pose2) -> Rays:
        """Return which rays (k,) of a scan returned something that travels with the robot.

        Args:
            scan: a scan soon after the last one, with its bearings; else it begins again.
            odometry: the robot in the odom frame at the scan's stamp.
        """
        elapsed, self._stamp = scan.stamp - self._stamp, scan.stamp
        if not (0 < elapsed < LONGEST and np.array_equal(scan.bearings, self._bearings)):
            self._begin(scan.bearings)
            self._last = None
        if len(scan.bearings) < FEWEST + BESIDE:
            return np.zeros(len(scan.bearings), bool)
        step = Pose2() if self._last is None else self._last.inverse() @ odometry
        self._last = odometry
        self._compare(scan, step)
        offset = np.where(scan.hit, scan.ranges, np.inf) - np.where(self._seen, self._range, 0.0)
        stayed = self._seen & (np.abs(offset) < SAME)
        nearer = self._seen & (offset < -SAME)
        back = np.maximum(self._missed - BACK, 0) * self._known
        self._missed = np.where(stayed, back, self._missed + ~(nearer & self._known))
        patience = np.where(self._known, GONE, np.where(nearer, HIDDEN, 0))
        replaced = ~stayed & (self._missed > patience)
        self._restart(replaced, scan)
        self._way += math.hypot(step.x, step.y)
        self._seen_way += np.where(stayed, math.hypot(step.x, step.y), 0.0)
        self._across += self._moved_across(scan, stayed, step)
        moved = self._moves - self._since >= MOVED
        far = np.abs(self._across) > ACROSS + ACROSS_SHARE * self._way
        stays = self._known | (stayed & far)
        self._known = _in_rows(self._known | (stays & moved))
        # What lies in one row with it belongs to it, and its ends, where no edge has a direction.
        self._known = self._known | _rows_with(stays, self._known)
        beside = np.convolve(self._known, np.ones(2 * BESIDE + 1), "same") > 0
        self._known = self._known | (beside & stayed & (self._seen_way > ACROSS))
        still: Rays = stayed & self._known
        return still

    def _compare(self, scan: Scan, step: Pose2) -> None:
        """Count the returns that have moved in the last stride."""
        self._stride += math.hypot(step.x, step.y) + ARM * abs(step.theta)
        if self._stride > STRIDE:
            self._stride = 0.0
            near = np.minimum(scan.ranges, self._compared) < REACH
            both = near & np.isfinite(self._compared) & scan.hit & ~self._known
            offsets = scan.ranges[both] - self._compared[both]
            self._moves += int(np.count_nonzero(np.abs(offsets) > SAME) >= FEWEST)
            self._compared = scan.ranges

    def _restart(self, replaced: Rays, scan: Scan) -> None:
        self._range = np.where(replaced, scan.ranges, self._range)
        self._seen = np.isfinite(self._range)
        self._known = self._known & ~replaced
        self._missed = np.where(replaced, 0, self._missed)
        self._since = np.where(replaced, self._moves, self._since)
        self._way = np.where(replaced, 0.0, self._way)
        self._seen_way = np.where(replaced, 0.0, self._seen_way)
        self._across = np.where(replaced, 0.0, self._across)

    def _moved_across(self, scan: Scan, stayed: Rays, step: Pose2) -> Array:
        """Return how far tape at each return would have moved across its edge [m]."""
        start, reach = scan.robot_from_scan, np.where(stayed, self._range, np.nan)
        heading = start.theta + scan.bearings
        ends = np.column_stack([np.cos(heading), np.sin(heading)]) * reach[:, None]
        ends += start.x, start.y
        along = np.full_like(ends, np.nan)
        along[BESIDE:-BESIDE] = ends[2 * BESIDE :] - ends[: -2 * BESIDE]
        length = np.hypot(along[:, 0], along[:, 1])
        flow = step.inverse().apply(ends) - ends
        across = (along[:, 0] * flow[:, 1] - along[:, 1] * flow[:, 0]) / length
        with np.errstate(invalid="ignore"):
            return np.where(length < 2 * BESIDE * APART, np.nan_to_num(across), 0.0)


def _in_rows(rays: Rays) -> Rays:
    """Return those of the rays that have enough neighbours among them."""
    row = np.ones(FEWEST, np.int64)
    whole = np.convolve(rays, row, "valid") == FEWEST
    inside: Rays = np.convolve(whole, row) > 0
    return inside


def _rows_with(rays: Rays, some: Rays) -> Rays:
    """Return the rows of neighbouring rays that have at least one of some others."""
    row = np.cumsum(np.diff(rays, prepend=False))
    with_some = np.bincount(row, some, len(rays) + 1) > 0
    within: Rays = rays & with_some[row]
    return within
