"""PathController: what turns a way and the robot's pose into a velocity; ours, and their names."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2, Twist2
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Wanted
from robot.navigation.tracker import follow

CUT_M = 0.004
"""The look-ahead point is so near that the straight line to it leaves the path by at most this [m]:
so corners are not cut, however long the look-ahead is."""


@dataclass(frozen=True, eq=False)
class Tracking:
    """What a controller knows in one tick."""

    pose: Pose2
    """Of the robot, as it is believed to be."""
    wanted: Wanted
    """Pose and velocity that the times of the way want now."""
    ahead: Twist2
    """The velocity that is wanted when the command takes effect."""
    path: Array
    """(n, 3) the poses from the nearest one on, to the end of the leg [m, m, rad]; one or more."""
    backwards: bool
    """Whether the leg is driven backwards."""
    twist: Twist2
    """As the wheels measure it."""
    pace: float
    """Share of its speed that the robot shall drive: less while its bound is wide."""
    settings: NavigationSettings

    @property
    def left(self) -> float:
        """The way to the end of the leg [m]."""
        return float(np.hypot(*np.diff(self.path[:, :2], axis=0).T).sum())


class PathController(Protocol):
    """Gives the velocity of each tick on a path; turns on the spot are not its own."""

    by_time: bool
    """Whether it keeps the times of the way. Else the time is that of the nearest pose."""

    def command(self, tracking: Tracking) -> Twist2:
        """Return the twist to command."""
        ...


class Tracker:
    """Drives what the way wants at each time, and adds what the robot is off."""

    by_time = True

    def command(self, tracking: Tracking) -> Twist2:
        """Return the twist to command."""
        return follow(tracking.pose, tracking.wanted, tracking.ahead, tracking.settings)


class RegulatedPurePursuit:
    """Drives towards a point ahead on the path, slower in bends and at the end.

    Macenski et al. 2023, by nav2's parameter names. The robot never turns on the spot in its middle
    of a path: turns are legs of their own, so it does not swing about a path's heading.
    """

    by_time = False

    def command(self, tracking: Tracking) -> Twist2:
        """Return the twist to command."""
        settings = tracking.settings
        speed = settings.desired_linear_vel * tracking.pace
        point = self._carrot(tracking, abs(tracking.twist.v))
        apart = point.x**2 + point.y**2
        bend = 0.0 if apart < 1e-9 else 2 * point.y / apart
        radius = math.inf if bend == 0 else 1 / abs(bend)
        if radius < settings.regulated_linear_scaling_min_radius:
            slowed = speed * radius / settings.regulated_linear_scaling_min_radius
            speed = min(speed, max(slowed, settings.regulated_linear_scaling_min_speed))
        left = tracking.left
        if left < settings.approach_velocity_scaling_dist:
            share = left / settings.approach_velocity_scaling_dist
            slowest = settings.min_approach_linear_velocity
            speed = min(speed, max(speed * share, slowest))
        speed *= -1.0 if tracking.backwards else 1.0
        return Twist2(speed, speed * bend)

    def _carrot(self, tracking: Tracking, speed: float) -> Pose2:
        """Return the point to drive to, seen from the robot."""
        settings = tracking.settings
        reach = min(
            max(speed * settings.lookahead_time, settings.min_lookahead_dist),
            settings.max_lookahead_dist,
        )
        points = tracking.pose.inverse().apply(tracking.path[:, :2])
        away = np.hypot(*points.T)
        within = np.flatnonzero(away > reach)
        last = int(within[0]) if len(within) else len(points) - 1
        while (
            last > 1 and _cut(points[: last + 1]) > CUT_M and away[last] > settings.lookahead_dist
        ):
            last -= 1
        x, y = points[last].tolist()
        if last == len(points) - 1 and away[last] < reach:
            # Beyond the end it goes on straight: a point beside the robot would turn it about.
            theta = float(tracking.path[-1, 2]) - tracking.pose.theta
            beyond = (reach - float(away[last])) * (-1.0 if tracking.backwards else 1.0)
            x, y = x + beyond * math.cos(theta), y + beyond * math.sin(theta)
        return Pose2(x, y)


def _cut(points: Array) -> float:
    """Return how far the straight line between the ends of points (n, 2) leaves them [m]."""
    line = points[-1] - points[0]
    length = float(np.hypot(*line))
    if length < 1e-9:
        return 0.0
    beside = points - points[0]
    return float(np.abs(beside[:, 0] * line[1] - beside[:, 1] * line[0]).max()) / length


@dataclass(frozen=True)
class ControllerKind:
    """A controller by its name."""

    name: str
    make: Callable[[], PathController]
    """Makes one for a journey."""


CONTROLLERS: Mapping[str, ControllerKind] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            ControllerKind("tracker", Tracker),
            ControllerKind("pursuit", RegulatedPurePursuit),
        )
    }
)
"""Ours, by the name in the settings."""
