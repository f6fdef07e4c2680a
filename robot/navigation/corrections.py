"""``corrected``: legs by which a robot that stands beside its goal comes to it."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Pose2, wrap_angle
from robot.navigation.free_space import FreeSpace
from robot.navigation.gates import comes_no_nearer
from robot.navigation.legs import WayLeg, curve, straight, turn
from robot.navigation.settings import NavigationSettings

CORRECTIONS_M = (-0.08, 0.08, -0.04, 0.04, -0.025, 0.025)
"""For that the robot goes back so far, or ahead, and comes again [m]: the first that has room."""
SMALL_TURN, SWING = 0.02, 0.25
"""For a turn smaller than the first it swings away by the second, and comes again [rad]."""
SIDESTEPS = 25
"""Points of the way back."""


def corrected(
    free: FreeSpace, start: Pose2, goal: Pose2, settings: NavigationSettings
) -> tuple[WayLeg, ...]:
    """Return legs that bring a robot that stands beside its goal there.

    Sideways it cannot go: it goes back and comes again, or ahead and back, where there is room.
    """
    beside = goal.inverse() @ start
    near = settings.xy_goal_tolerance / 2
    if abs(beside.y) > near:
        for distance in CORRECTIONS_M:
            away = _sidestep(start, goal, distance)
            back = straight(goal @ Pose2(distance), -distance)
            if comes_no_nearer(free, away, start) and comes_no_nearer(free, back, goal):
                return away, back
    legs: list[WayLeg] = []
    if abs(beside.theta) > settings.yaw_goal_tolerance / 2:
        legs.extend(_turned_to(free, start, goal.theta))
    if abs(beside.x) > near:
        legs.append(straight(Pose2(start.x, start.y, goal.theta), -beside.x))
    return tuple(legs)


def is_there(pose: Pose2, goal: Pose2, settings: NavigationSettings) -> bool:
    """Whether a pose is the goal's, within the tolerances."""
    turned = abs(wrap_angle(goal.theta - pose.theta))
    near = pose.distance_to(goal) <= settings.xy_goal_tolerance
    return near and turned <= settings.yaw_goal_tolerance


def _turned_to(free: FreeSpace, start: Pose2, theta: float) -> tuple[WayLeg, ...]:
    """Return turns on the spot to a heading [rad]; the robot swings away for a very small one.

    Its wheels do not turn as slowly as that asks for.
    """
    swings = (
        (SWING, -SWING, SWING / 2, -SWING / 2)
        if abs(wrap_angle(theta - start.theta)) < SMALL_TURN
        else ()
    )
    for swing in swings:
        away = turn(start, theta + swing)
        back = turn(away.end, theta)
        if comes_no_nearer(free, away, start):
            return away, back
    direct = turn(start, theta)
    return (direct,) if comes_no_nearer(free, direct, start) else ()


def all_around(pose: Pose2) -> tuple[WayLeg, ...]:
    """Return a whole turn on the spot, in parts."""
    legs = []
    for _ in range(3):
        legs.append(turn(pose, pose.theta + 2 * math.pi / 3))
        pose = legs[-1].end
    return tuple(legs)


def _sidestep(start: Pose2, goal: Pose2, distance: float) -> WayLeg:
    """Return a way from beside a goal onto its line, so far ahead of it [m] or behind."""
    beside = goal.inverse() @ start
    share = np.linspace(0.0, 1.0, SIDESTEPS)
    smooth = share**3 * (10 - 15 * share + 6 * share**2)
    along = beside.x + share * (distance - beside.x)
    points = goal.apply(np.column_stack([along, beside.y * (1 - smooth)]))
    return curve(points, backwards=distance < beside.x)
