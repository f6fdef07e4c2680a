"""Arrival: judges whether a robot has come to its goal; it remembers that the robot was there."""

from __future__ import annotations

import math
from enum import Enum

from robot.geometry import Pose2, wrap_angle
from robot.localization.estimate import Integrity
from robot.navigation.goal import Goal
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings

SETTLE_S = 0.12
"""The robot stands so long before its end is judged: the filter sees it at rest [s].
Half and twice: 1.17, 1.15 and 1.23 of the fastest time with half, 1.19, 1.23 and 1.28 with twice,
instead of 1.17, 1.15 and 1.23; places are as exact (``evaluate navigation --map town generated-9111
generated-9112 --seeds 1 --first-seed 7710 --goals 10``)."""
LATE_S = 1.0
"""So long after its time is over, it stands even if it is not near enough to the end [s]."""
MOST_CORRECTIONS, MISSED_SDS = 6, 3.0
"""So often an end that is too far from its goal is driven to again; then the journey has failed,
unless it is no more standard deviations of its estimate beside the goal. Half of MISSED_SDS: one of
1440 journeys fails (*generated-9203*, seed 8800); twice: no more of them arrive."""
VAGUE_M = 0.035
"""At a goal where its bound is wider than this, the robot turns around once to see more [m]."""
VAGUE_RAD = 0.05
"""A robot that knows its heading no better says so when it arrives [rad]. Half: it says so at 8 of
19 goals on ``generated-9101``, of which 7 are less than 0.5 degrees off; twice: at the same 2 of
them, where its bounds are 8.1 and 8.7 degrees, and at the others 1.9 at most."""


class WayEnd(Enum):
    """What is to be done at the end of a way."""

    THERE = "there"
    AGAIN = "again"
    """It stands beside its goal, and comes again."""
    BESIDE = "beside"
    """It has come again often enough."""


class Arrival:
    """The end of the way to one goal after the other."""

    def __init__(self, settings: NavigationSettings) -> None:
        """Judge by the tolerances of settings."""
        self._settings = settings
        self.begin()

    def begin(self) -> None:
        """Begin with another goal."""
        self.reached = False
        """Whether the place of the goal was reached: then only the heading is left."""
        self.seeks = False
        """Whether the robot shall turn around there to see more."""
        self._sought = False
        """Whether it has."""
        self.vagueness = ""
        """How well it knows only where it stands there, in words; empty if it knows it well."""
        self._corrections = 0
        self.leave()

    def leave(self) -> None:
        """Note that the robot is not at the end of its way, or not any more."""
        self._over_since: float | None = None
        """When the time of its way was over [s]."""
        self._stands_since: float | None = None

    def stands(self, tick: Sensed, pose: Pose2, end: Pose2) -> bool:
        """Whether the robot has come to the end of its way, whose time is over, and stands."""
        if self._stands_since is not None:
            return True
        self._over_since = tick.stamp if self._over_since is None else self._over_since
        error = pose.inverse() @ end
        is_there = abs(error.x) <= self._settings.xy_goal_tolerance / 2
        is_turned = abs(error.theta) <= self._settings.yaw_goal_tolerance / 2
        late = tick.stamp - self._over_since > LATE_S
        if not (is_there and is_turned and tick.stands) and not late:
            return False
        self._stands_since = tick.stamp
        return True

    def has_settled(self, stamp: float) -> bool:
        """Whether it stands so long that its end can be judged."""
        return self._stands_since is not None and stamp - self._stands_since >= SETTLE_S

    def judge(self, pose: Pose2, goal: Goal, tick: Sensed) -> WayEnd:
        """Return what is to be done, for a robot whose place is known as well as its tick says."""
        self.reached = True
        self.leave()
        self.vagueness = _vagueness(goal, tick.integrity)
        if tick.integrity.radius > VAGUE_M and not self._sought:
            self.seeks = self._sought = True
            return WayEnd.AGAIN
        distance, turned = _beside(pose, goal)
        settings = self._settings
        if distance <= settings.xy_goal_tolerance and turned <= settings.yaw_goal_tolerance:
            return WayEnd.THERE
        if self._corrections >= MOST_CORRECTIONS:
            # What it sees at the goal leads elsewhere than what it saw on its way, each time.
            if distance > MISSED_SDS * tick.spread or turned > settings.yaw_goal_tolerance:
                return WayEnd.BESIDE
            self.vagueness = self.vagueness or _vague_place(tick.integrity)
            return WayEnd.THERE
        self._corrections += 1
        return WayEnd.AGAIN

    def miss(self, pose: Pose2, goal: Goal) -> str:
        """Return in words how far from its goal the robot stands after all corrections."""
        distance, turned = _beside(pose, goal)
        place, heading = self._settings.xy_goal_tolerance, self._settings.yaw_goal_tolerance
        return (
            f"it stands {1000 * distance:.1f} mm and {math.degrees(turned):.1f} degrees beside the "
            f"goal and comes no nearer; valid is a xy_goal_tolerance above "
            f"{1000 * place:.1f} mm, or a yaw_goal_tolerance above {math.degrees(heading):.1f} "
            "degrees"
        )


def _vagueness(goal: Goal, known: Integrity) -> str:
    """Return in words what a robot does not know well at its goal; empty if it knows all."""
    if known.radius > VAGUE_M:
        return _vague_place(known)
    if known.heading_bound > VAGUE_RAD and goal.theta is not None:
        degrees = math.ceil(math.degrees(known.heading_bound))
        return f"its heading is known to {degrees} degrees only"
    return ""


def _vague_place(known: Integrity) -> str:
    return f"its place is known to {10 * math.ceil(100 * known.radius)} mm only"


def _beside(pose: Pose2, goal: Goal) -> tuple[float, float]:
    """Return how far a pose is from a goal [m], and from its heading [rad]; 0 where any will do."""
    turned = 0.0 if goal.theta is None else abs(wrap_angle(goal.theta - pose.theta))
    return math.hypot(goal.x - pose.x, goal.y - pose.y), turned
