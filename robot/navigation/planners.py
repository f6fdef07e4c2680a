"""PlannerKind: a way of finding ways, by its name; ours, and how one is made of corners."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.legs import WayLeg
from robot.navigation.planning import NoWayError, Planner, plan, plan_by_corners

PATIENCE_S = 0.06
"""A way of a planner that is not said otherwise is driven so long after it was asked for [s]."""


@dataclass(frozen=True)
class PlannerKind:
    """A planner."""

    name: str
    plan: Planner
    """Returns legs from a pose to another one, or raises a ``NoWayError``. It may be called in any
    thread."""
    patience: float = PATIENCE_S
    """A way is driven this long after its planning began [s], on the robot's clock."""
    ends: bool = False
    """Whether it is known to end: it is waited for, however busy the computer is."""


def _in_headings(free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...]:
    from robot.navigation.lattice import plan_in_headings  # noqa: PLC0415 - few use it

    return plan_in_headings(free, start, goal)


def find_way(free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...]:
    """Return legs by ``plan``, or where they would have to turn without room, by headings.

    The robot is longer than it is wide: there are passages in which it fits, but cannot turn.

    Raises:
        NoWayError: neither finds a way; says why the first does not.
    """
    try:
        return plan(free, start, goal)
    except NoWayError as error:
        if not free.thorough:
            raise
        try:
            return _in_headings(free, start, goal)
        except NoWayError:
            raise error from None


def _at_random(free: FreeSpace, start: Pose2, goal: Pose2) -> tuple[WayLeg, ...]:
    from robot.navigation.random_tree import random_corners  # noqa: PLC0415 - few use it

    return plan_by_corners(random_corners)(free, start, goal)


PLANNERS: Mapping[str, PlannerKind] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            PlannerKind("grid", find_way, ends=True),
            PlannerKind("lattice", _in_headings, 0.15, ends=True),
            PlannerKind("rrt", _at_random, 1.5, ends=True),
        )
    }
)
"""Ours, by the name in the settings."""
