"""``plan``: the way to a goal, as legs; a planner is any function like it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2, wrap_angle
from robot.navigation.free_space import FreeSpace
from robot.navigation.gates import AHEAD, gate
from robot.navigation.grid_search import search, straighten
from robot.navigation.legs import STEP, WayLeg, curve, rounded, straight, turn

Planner = Callable[[FreeSpace, Pose2, Pose2], tuple[WayLeg, ...]]
"""Returns legs from a pose to another one, or raises a ``NoWayError``."""

Corners = Callable[[FreeSpace, Pose2, Pose2], Array]
"""Returns the corners (n, 2) [m] of a path between two places where the robot may turn."""

SAME_PLACE, SAME_HEADING = 0.0005, 0.002
"""Nearer places [m] and headings [rad] count as the same."""
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
    leaving = gate(free, start, away=True)
    if leaving is None:
        raise NoWayError(
            "the robot stands too near to a wall to turn, also after going straight: drive it "
            "away by hand"
        )
    coming = gate(free, goal, away=False)
    if coming is None:
        raise NoWayError(
            "at the goal there is no room to turn, and no straight way to it; valid is a goal "
            f"{1000 * (free.radius + free.kept):.0f} mm from walls"
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
    if free.admits(goal):
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
    if abs(ahead.theta) > SAME_HEADING or abs(ahead.y) > SAME_PLACE or abs(ahead.x) > AHEAD[-1]:
        return None
    leg = straight(start, ahead.x)
    return (leg,) if free.fits(leg.poses) else None


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
