"""``plan``: the way to a goal, as legs; a planner is any function like it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2, wrap_angle
from robot.navigation.free_space import FreeSpace
from robot.navigation.grid_search import search, straighten
from robot.navigation.legs import STEP, WayLeg, curve, rounded, straight, turn

Planner = Callable[[FreeSpace, Pose2, Pose2], tuple[WayLeg, ...]]
"""Returns legs from a pose to another one, or raises a ``NoWayError``."""

Corners = Callable[[FreeSpace, Pose2, Pose2], Array]
"""Returns the corners (n, 2) [m] of a path between two places where the robot may turn."""

Gate = tuple[tuple[WayLeg, ...], Pose2]
"""Legs between a pose and a place where the robot may turn, and that place's pose."""

SAME_PLACE, SAME_HEADING = 0.0005, 0.002
"""Nearer places [m] and headings [rad] count as the same."""
GATES = (0.0, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3, -0.03, -0.06, -0.1, -0.15, -0.2, -0.3)
"""Where the robot cannot turn, it goes straight so far to where it can [m]."""
PART_TURNS = (0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.25, 1.5)
"""Where that does not help, it first turns so far, if there is room for that [rad]."""
SAME_ROOM = 0.0016
"""The room to walls is known no better, since their cells are as large [m]."""
PARTED = "a wall is between the robot and the goal, and no way leads around it"
SMOOTHINGS = (1.0, 0.5, 0.25)
"""Shares of the smoothing that are tried, until the robot fits along the rounded path."""


class NoWayError(BrickPoseError, ValueError):
    """There is no way to a goal, or the goal itself is not free; the message says which."""


def plan(free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...]:
    """Return legs from a start to a goal, on which the robot keeps its clearance.

    It turns on the spot at the start, drives a rounded path, and turns on the spot at the goal.
    Where a wall is too near to turn, it first goes straight, and comes straight to the goal.

    Raises:
        NoWayError: a wall is at the goal, or between the two.
    """
    return _plan(free, start, goal, _corners)


def plan_by_corners(corners: Corners) -> Planner:
    """Return a planner whose paths have the corners that a function finds.

    Turns, rounding, and the ways from and to places beside walls are those of ``plan``.
    """

    def planner(free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...]:
        return _plan(free, start, goal, corners)

    return planner


def _plan(free: FreeSpace, start: Pose2, goal: Pose2, corners: Corners) -> tuple[WayLeg, ...]:
    require_joined(free, start, goal)
    if start.distance_to(goal) < SAME_PLACE:
        if abs(start.turn_to(goal)) < SAME_HEADING:
            return ()
        if free.turns(_places(start)):
            return (turn(start, goal.theta),)
    short = _short_way(free, start, goal)
    if short is not None:
        return short
    leaving = next(_gates(free, start, away=True), None) or _turned_gate(free, start)
    if leaving is None:
        raise NoWayError(
            "the robot stands too near to a wall to turn, also after going straight: drive it "
            "away by hand"
        )
    coming = next(_gates(free, goal, away=False), None) or _turned_gate(free, goal, coming=True)
    if coming is None:
        raise NoWayError(
            "at the goal there is no room to turn, and no straight way to it; valid is a goal "
            f"{1000 * (free.radius + free.settings.clearance):.0f} mm from walls"
        )
    (first, begin), (last, end) = leaving, coming
    return (*first, *_between(free, begin, end, corners), *last)


def require_joined(free: FreeSpace, start: Pose2, goal: Pose2) -> None:
    """Refuse a goal where the robot would not fit, or around which walls lie without a gap.

    Raises:
        NoWayError: says which.
    """
    require_free(free, goal)
    if free.are_parted(start, goal):
        raise NoWayError(PARTED)


def require_free(free: FreeSpace, goal: Pose2) -> None:
    """Refuse a goal where the robot would not fit.

    Raises:
        NoWayError: a wall is there; the message says how near.
    """
    if free.fits(goal.to_array()[None]):
        return
    if free.stands_in_wall(goal):
        raise NoWayError("at the goal the robot would stand on a wall or beyond the floor")
    raise NoWayError(
        f"at the goal the robot is nearer to a wall than {1000 * free.settings.clearance:.0f} mm"
    )


def _short_way(free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...] | None:
    """Return the way that is only a straight line, for a goal ahead or behind; None if it is not.

    So a robot that has stopped just beside its goal does not turn about for a few millimetres.
    """
    ahead = start.inverse() @ goal
    if abs(ahead.theta) > SAME_HEADING or abs(ahead.y) > SAME_PLACE or abs(ahead.x) > -GATES[-1]:
        return None
    leg = straight(start, ahead.x)
    return (leg,) if free.fits(leg.poses) else None


def _gates(free: FreeSpace, pose: Pose2, *, away: bool) -> Iterator[Gate]:
    """Yield straight ways from a pose, or to it, with the other end, where the robot may turn."""
    for distance in GATES:
        other = pose @ Pose2(distance if away else -distance)
        if not free.turns(_places(other)):
            continue
        if distance == 0:
            yield (), other
            continue
        leg = straight(pose, distance) if away else straight(other, distance)
        if comes_no_nearer(free, leg, pose):
            yield (leg,), other


def _turned_gate(free: FreeSpace, pose: Pose2, *, coming: bool = False) -> Gate | None:
    """Return a gate after turning a part, or before it; None if that does not help either.

    Beside a wall the robot can often turn away from it, though not all around.
    """
    for sign in (1.0, -1.0):
        for angle in PART_TURNS:
            turned = pose @ Pose2(0.0, 0.0, sign * angle)
            if not comes_no_nearer(free, turn(pose, turned.theta), pose):
                break
            gate = next(_gates(free, turned, away=not coming), None)
            if gate is None:
                continue
            legs, other = gate
            return ((*legs, turn(turned, pose.theta)) if coming
                    else (turn(pose, turned.theta), *legs)), other  # fmt: skip
    return None


def comes_no_nearer(free: FreeSpace, leg: WayLeg, pose: Pose2) -> bool:
    """Whether a leg keeps the clearance, or what room a pose at its end has that has less.

    From a pose in a wall the leg may lead out of it, but not into it again.
    """
    room = float(free.room(pose.to_array()[None])[0])
    rooms = free.room(leg.poses)
    if room <= 0:
        clear = rooms > 0
        return bool((clear[1:] >= clear[:-1]).all() or (clear[1:] <= clear[:-1]).all())
    kept = min(free.settings.clearance, room - SAME_ROOM)
    return bool(((rooms >= kept) & (rooms > 0)).all())


def _between(free: FreeSpace, begin: Pose2, end: Pose2, corners: Corners) -> list[WayLeg]:
    """Return the turn at the beginning, the path, and the turn at the end."""
    if begin.distance_to(end) < SAME_PLACE:
        return _turn_if_needed(begin, end.theta)
    way = _path(free, corners(free, begin, end))
    ahead = way.poses[0, 2]
    back = way.poses[-1]
    return [
        *_turn_if_needed(begin, ahead),
        way,
        *_turn_if_needed(Pose2.from_array(back), end.theta),
    ]


def _turn_if_needed(pose: Pose2, theta: float) -> list[WayLeg]:
    return [] if abs(wrap_angle(theta - pose.theta)) < SAME_HEADING else [turn(pose, theta)]


def _path(free: FreeSpace, corners: Array) -> WayLeg:
    """Return the curve along corners (n, 2) [m] between two places where the robot may turn."""
    for share in SMOOTHINGS:
        points = rounded(corners, share * free.settings.smoothing)
        if free.turns(points):
            return curve(points)
    raise NoWayError("the way is too narrow to drive around its corners")


def _corners(free: FreeSpace, begin: Pose2, end: Pose2) -> Array:
    """Return the corners (n, 2) [m] of the cheapest path."""
    costs = free.costs
    start, goal = _open_cell(free, begin), _open_cell(free, end)
    path = search(costs, start, goal)
    if not len(path):
        raise NoWayError(PARTED)
    cells = straighten(costs, path)
    middles = (cells[:, ::-1] + 0.5) * free.settings.resolution + free.origin
    inner = middles[1:-1]
    points = np.concatenate([[[begin.x, begin.y]], inner, [[end.x, end.y]]])
    # A corner in the cell beside an end would bend the path there.
    far = np.hypot(*np.diff(points, axis=0).T) > STEP
    far[-1] = True
    return points[np.concatenate([[True], far])] if len(points) > 2 else points


def _open_cell(free: FreeSpace, pose: Pose2) -> tuple[int, int]:
    """Return the cell of a place where the robot may turn, or an open one beside it."""
    row, column = free.cell(pose.x, pose.y)
    height, width = free.costs.shape
    near = sorted(
        (math.hypot(down, right), row + down, column + right)
        for down in range(-3, 4)
        for right in range(-3, 4)
    )
    for _, y, x in near:
        if 0 <= y < height and 0 <= x < width and math.isfinite(free.costs[y, x]):
            return y, x
    return row, column


def _places(pose: Pose2) -> Array:
    return np.array([[pose.x, pose.y]])
