"""``way_to`` and ``way_onto``: the next way with its times, worked out beside the robot's ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from robot.geometry import Pose2
from robot.navigation.corrections import all_around, corrected, is_there
from robot.navigation.curves import Lap
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.legs import WayLeg
from robot.navigation.planning import NoWayError, Planner
from robot.navigation.settings import REFUSED, NavigationSettings
from robot.navigation.timed_way import SAMPLE_S, Limits, TimedWay, timed, timed_loop

GOAL_STAYS = 0.015
"""A place that was reached counts so until the robot is farther away from it [m]."""
ON_CURVE = 0.02
"""A robot that is farther from a closed curve first drives to it as to a goal [m; rad / 5]."""
AHEAD_S = 1.0
"""At each time counts the least room to walls in so much time from there on [s]."""
ROOM_EVERY = 3
"""Room is worked out at each third moment of a way: at 0.2 m/s that is each 12 mm."""


@dataclass(frozen=True, eq=False)
class Planning:
    """How ways are planned in a journey."""

    planner: Planner
    settings: NavigationSettings
    limits: Limits

    def timed(self, space: FreeSpace, legs: tuple[WayLeg, ...]) -> TimedWay:
        """Return legs with times and with room to walls."""
        return with_room(space, timed(legs, self.limits))


@dataclass(frozen=True, eq=False)
class Approach:
    """Where the robot stands, and to which goal it comes."""

    start: Pose2
    goal: Goal
    reached: bool = False
    """Whether it was there before: then it only corrects what is missing."""
    seeks: bool = False
    """Whether it turns around to see more."""
    bound: float = 0.0
    """How well it knows its place [m]: its outline grown by that shall come to no wall."""

    @property
    def end(self) -> Pose2:
        """The pose at the goal; without a heading, that of the straight way there."""
        start, goal = self.start, self.goal
        if goal.theta is not None:
            return Pose2(goal.x, goal.y, goal.theta)
        return Pose2(goal.x, goal.y, math.atan2(goal.y - start.y, goal.x - start.x))


def way_to(space: FreeSpace, approach: Approach, planning: Planning) -> TimedWay | None:
    """Return the way to a goal; None if there is nothing to drive.

    Raises:
        NoWayError: there is none; says why.
    """
    legs = _legs_at_goal(space, approach, planning.settings)
    if legs is None:
        return _way_there(space, approach, planning)
    return planning.timed(space, legs) if legs else None


def _legs_at_goal(
    space: FreeSpace, approach: Approach, settings: NavigationSettings
) -> tuple[WayLeg, ...] | None:
    """Return what is left to drive for a robot that was there; None if it has to come anew."""
    start, end = approach.start, approach.end
    if approach.seeks and space.turns(start.to_array()[None, :2]):
        return all_around(start)
    if approach.reached and start.distance_to(end) <= GOAL_STAYS:
        legs = corrected(space, start, end, settings)
        # Without room to correct it, an end beside the goal is no arrival: it comes anew.
        if legs or is_there(start, end, settings):
            return legs
    return None


def _way_there(space: FreeSpace, approach: Approach, planning: Planning) -> TimedWay | None:
    """Return the way on which the outline grown by the bound is clear of walls, or another one."""
    start, end = approach.start, approach.end
    known = approach.bound <= planning.settings.stop_radius
    roomy = space.for_bound(approach.bound if known else 0.0)
    refuses, bound = planning.settings.narrow_ways == REFUSED, 1000 * roomy.kept
    narrow = ""
    if roomy is not space and not roomy.fits(end.to_array()[None]) and space.admits(end):
        narrow = f"at the goal a wall is nearer than the {bound:.0f} mm to which its place is known"
        if refuses:
            raise NoWayError(narrow)
    try:
        legs = planning.planner(roomy, start, end)
    except NoWayError as error:
        if roomy is space:
            raise
        legs = planning.planner(space, start, end)  # where no way leads at all, it says why
        narrow = f"its way keeps no {bound:.0f} mm from walls, to which its place is known"
        if refuses:
            raise NoWayError(narrow) from error
    if not legs:
        return None
    return replace(planning.timed(space, legs), bound=roomy.kept, narrow=narrow)


def way_onto(
    space: FreeSpace, start: Pose2, lap: Lap, planning: Planning, bound: float = 0.0
) -> TimedWay | None:
    """Return the lap of a closed curve, or the way to it if the robot does not stand on it.

    ``bound`` is how well it knows its place [m].

    Raises:
        NoWayError: a wall is in the way.
    """
    if planning.settings.narrow_ways == REFUSED:
        space = space.for_bound(bound)
    if not space.fits(lap.poses):
        raise NoWayError(
            "along the curve the robot would touch a wall, or be nearer to it than "
            f"{1000 * space.kept:.0f} mm; valid is a smaller one, or "
            "another place to begin"
        )
    turned = abs(lap.begin.turn_to(start)) / 5
    if max(lap.begin.distance_to(start), turned) <= ON_CURVE:
        way = with_room(space, timed_loop(lap.legs, planning.limits))
        return replace(way, bound=space.kept)
    return way_to(space, Approach(start, Goal(*lap.begin.to_array()), bound=bound), planning)


def with_room(space: FreeSpace, way: TimedWay) -> TimedWay:
    """Return a way that knows how much room its outline has to walls."""
    some = space.hollow.room(way.poses[::ROOM_EVERY])
    count = max(1, round(AHEAD_S / SAMPLE_S / ROOM_EVERY))
    padded = np.concatenate([some, np.full(count - 1, np.inf)])
    least = np.lib.stride_tricks.sliding_window_view(padded, count).min(axis=1)
    return replace(way, room=np.repeat(least, ROOM_EVERY)[: len(way.times)])
