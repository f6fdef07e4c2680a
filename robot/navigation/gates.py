"""``gate``: between a pose beside walls and a place where the robot may turn, a way of its legs."""

from __future__ import annotations

import heapq
import math
import sys
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from robot.geometry import Array, Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.legs import WayLeg, straight, turn
from robot.navigation.place_kernels import rooms

Gate = tuple[tuple[WayLeg, ...], Pose2]
"""Legs between a pose and a place where the robot may turn, and that place's pose."""

AHEAD = (0.03, 0.06, 0.1, 0.15, 0.2, 0.3)
"""Where the robot cannot turn, it goes straight so far to where it can [m]. Half: the way from 300
poses beside walls of *tee* takes 1.17 s in place of 1.35; twice: 1.62."""
BACK = tuple(-distance for distance in AHEAD)
"""Or so far back [m]."""
TURNS = (0.03, 0.06, *(0.1 * tenths for tenths in range(1, 32)))
"""Where that does not help, it turns so far to either side [rad], and goes straight; and again, as
a driver who leaves a narrow gap. Half and twice: 3 and 1 of these 300 have no way, 2 as it is."""
LEG_S, SPEED, TURNING = 0.5, 0.2, 1.8
"""What a leg takes: so long to begin and to end [s], and for the rest [m/s, rad/s]. Half and twice:
1.33 to 1.38 s, and 1 or 2 have no way."""
SAME_M, SAME_RAD = 0.01, 0.05
"""Poses that are nearer to each other are one. Half and twice: 3 and 1 have no way."""
MOST_POSES = 1000
"""Poses from which legs are tried; then no way out is known. Half: 7 have no way; twice: 1, and one
that has none takes a second to be refused."""
SAME_ROOM = 0.0016
"""The room to walls is known no better, since their cells are as large [m]."""


class _Reached(NamedTuple):
    """A pose that turns and straight ways lead to."""

    key: float
    """Poses with a small one are gone on from first [s]."""
    number: int
    seconds: float
    """What the way here takes."""
    pose: Pose2
    before: _Reached | None = None
    distance: float = 0.0
    """Of the straight way here [m]; zero after a turn."""

    @property
    def legs(self) -> tuple[WayLeg, ...]:
        """The way here."""
        if self.before is None:
            return ()
        last = self.before.pose
        leg = straight(last, self.distance) if self.distance else turn(last, self.pose.theta)
        return (*self.before.legs, leg)


def gate(free: FreeSpace, pose: Pose2, *, away: bool) -> Gate | None:
    """Return a way from a pose to where the robot may turn, or from there to it; None without one.

    On it the robot keeps its clearance, or what room it has at the pose if that is less.
    """
    straight_way = next(_straight_ways(free, pose, away=away), None)
    if straight_way is not None or not free.thorough:
        return straight_way
    way = _way_out(free, pose)
    if way is None or away:
        return way
    legs, other = way
    return tuple(_reversed(leg) for leg in reversed(legs)), other


def comes_no_nearer(free: FreeSpace, leg: WayLeg, pose: Pose2) -> bool:
    """Whether a leg keeps the clearance, or what room a pose at its end has that has less.

    From a pose in a wall the leg may lead out of it, but not into it again.
    """
    room = float(free.room(pose.to_array()[None])[0])
    rooms_there = free.room(leg.poses)
    if room <= 0:
        clear = rooms_there > 0
        return bool((clear[1:] >= clear[:-1]).all() or (clear[1:] <= clear[:-1]).all())
    return bool((rooms_there >= _kept(free, room)).all())


def _kept(free: FreeSpace, room: float) -> float:
    """Return what a robot with so much room keeps [m]."""
    return max(min(free.kept, room - SAME_ROOM), sys.float_info.min)


def _straight_ways(free: FreeSpace, pose: Pose2, *, away: bool) -> Iterator[Gate]:
    """Yield straight ways from a pose, or to it, with the other end, where the robot may turn."""
    for distance in (0.0, *AHEAD, *BACK):
        other = pose @ Pose2(distance if away else -distance)
        if not free.turns(np.array([[other.x, other.y]])):
            continue
        if distance == 0:
            yield (), other
            continue
        leg = straight(pose, distance) if away else straight(other, distance)
        if comes_no_nearer(free, leg, pose):
            yield (leg,), other


def _way_out(free: FreeSpace, pose: Pose2) -> Gate | None:
    """Return turns and straight ways to where the robot may turn.

    A* by the time they take; the robot has to go at least as far as room to turn is lacking.
    """
    room = float(free.room(pose.to_array()[None])[0])
    kept = _kept(free, room)
    needed = free.radius + free.kept
    open_poses = [_Reached(0.0, 0, 0.0, pose)]
    closed: set[tuple[int, int, int]] = set()
    number = 0
    while open_poses and len(closed) < MOST_POSES:
        reached = heapq.heappop(open_poses)
        x, y, theta = reached.pose.to_array()
        cell = round(x / SAME_M), round(y / SAME_M), round(theta / SAME_RAD)
        if cell in closed:
            continue
        closed.add(cell)
        in_wall = room <= 0 and reached.before is None
        for after in _next(free, reached, -math.inf if in_wall else kept):
            lacking = needed - float(free.clearance(np.array([[after.pose.x, after.pose.y]]))[0])
            if in_wall and not _leads_out(free, after.legs[0]):
                continue
            if lacking <= 0:
                return after.legs, after.pose
            number += 1
            key = after.seconds + lacking / SPEED
            heapq.heappush(open_poses, after._replace(key=key, number=number))
    return None


def _next(free: FreeSpace, reached: _Reached, kept: float) -> Iterator[_Reached]:
    """Yield what turns and straight ways lead to, by turns, and both from the first pose."""
    pose, before, seconds = reached.pose, reached.before, reached.seconds + LEG_S
    if before is None or reached.distance:
        for angle in _angles(free, pose, kept):
            turned = Pose2(pose.x, pose.y, pose.theta + angle)
            yield _Reached(0.0, 0, seconds + abs(angle) / TURNING, turned, reached)
    if before is None or not reached.distance:
        for distance in _distances(free, pose, kept):
            moved = pose @ Pose2(distance)
            yield _Reached(0.0, 0, seconds + abs(distance) / SPEED, moved, reached, distance)


def _angles(free: FreeSpace, pose: Pose2, kept: float) -> list[float]:
    """Return the turns on the spot for which there is room [rad]."""
    steps = np.array(TURNS)
    angles_clear = []
    for angles in (steps, -steps):
        poses = np.tile(pose.to_array(), (len(angles), 1))
        poses[:, 2] += angles
        angles_clear += angles[: _clear(free, poses, kept)].tolist()
    return angles_clear


def _distances(free: FreeSpace, pose: Pose2, kept: float) -> list[float]:
    """Return the straight ways for which there is room [m]."""
    clear = []
    for some in (AHEAD, BACK):
        way = straight(pose, some[-1]).poses
        reach = _clear(free, way[1:], kept) / (len(way) - 1) * abs(some[-1])
        clear += [distance for distance in some if abs(distance) <= reach]
    return clear


def _leads_out(free: FreeSpace, leg: WayLeg) -> bool:
    """Whether a leg from a pose in a wall leaves it, and does not come into it again."""
    begin = Pose2.from_array(leg.poses[0])
    return bool(free.room(leg.poses[-1:])[0] > 0) and comes_no_nearer(free, leg, begin)


def _clear(free: FreeSpace, poses: Array, kept: float) -> int:
    """Return how many poses (n, 3) follow each other before one has less room than is kept."""
    room = rooms(np.ascontiguousarray(poses), free.body, free.distance, free.frame)
    blocked = np.flatnonzero(room < kept)
    return int(blocked[0]) if len(blocked) else len(poses)


def _reversed(leg: WayLeg) -> WayLeg:
    """Return the same poses the other way round; what was driven ahead is driven backwards."""
    return WayLeg(leg.poses[::-1].copy(), not leg.backwards and not leg.on_spot)
