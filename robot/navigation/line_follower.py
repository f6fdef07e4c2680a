"""LineFollower: follows tape by what the camera sees, without any map or place."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import numpy as np

from robot.geometry import Array, Pose2, Twist2
from robot.navigation.navigation_status import NavigationState, NavigationStatus
from robot.navigation.possible_places import Glimpse
from robot.navigation.seen_tape import tape_in
from robot.navigation.sensed import Sensed
from robot.navigation.timed_way import Limits

REMEMBERED = 30
"""Views whose tape is remembered: the camera does not see the floor just before the robot. With 1,
a robot in a right-angled corner of ``square`` saw no tape, and stood."""
APART_M, APART_RAD = 0.015, 0.1
"""A view is remembered that was taken so far from the one before [m, rad]."""
BEGINS_M = 0.5
"""Tape that is nearer than this is driven to [m]."""
NEAR_M, FAR_M = 0.08, 0.14
"""It drives towards tape that is so far away [m]."""
SIDE_RAD = 1.75
"""Tape farther to a side is behind the robot: it came from there [rad]."""
PASSED_M = 0.045
"""Tape that is nearer to where the robot was is behind it, however it has turned since [m]: else it
came back from the end of a tape along its other edge."""
WIDE_M = 0.035
"""Tape within this of the point that is most ahead is the same: its middle is driven to [m]."""
BACK_M, MOST_BACK_RAD = 0.2, 0.5
"""Straight on is by where it was so far back, and at most so much beside its heading [m, rad]. By
its heading alone, tape that crosses at 60 degrees turned it aside."""
SAME_RAD = 0.2
"""Tape is the same if it is no farther beside that point's bearing [rad]. With 0.3, the beginning
of tape that crosses at 45 degrees was a part of it, and turned the robot aside."""
TURNS_RAD = 0.9
"""It turns on the spot while that is farther to a side [rad]."""
BEND_M = 0.15
"""It drives half as fast in a bend of this radius [m]."""
GAP_M = 0.25
"""Where no tape is so near, it drives to what is no farther than this [m]: in a corner, the tape
around it was not in sight."""
SEARCH_RAD, SEARCH_S = 0.8, 1.5
"""A robot that sees no tape any more turns so fast, so long to the side to which it turned last,
and then as far to the other one [rad/s, s]."""
BLIND_S = 1.0
"""A robot that has not seen any gives up after so long [s]."""


class LineFollower:
    """Follows a tape from the nearest one ahead to its end, or round and round.

    Tape that was seen is kept in the odometry's frame. The robot pursues what is a little ahead of
    it, and most straight on: so it goes around corners, and straight on where tape crosses. Where
    tape ends at another one, it goes to the side that is more ahead of it.
    """

    looks = False
    """It never looks for its place."""

    def __init__(self, speed: float, limits: Limits, *, name: str | int | None = None) -> None:
        """Begin to follow, at a speed [m/s]."""
        self.status = NavigationStatus("driving", (), name)
        self._speed = min(speed, limits.speed)
        self._limits = limits
        self._seen: deque[tuple[Pose2, Array]] = deque(maxlen=REMEMBERED)
        self._newest: Glimpse | None = None
        self._tape = np.zeros((0, 2))
        """(n, 2) in the odometry's frame [m]."""
        self._follows = False
        """Whether it has come to tape."""
        self._blind_since: float | None = None
        self._side = 1.0
        """To which it turned last: 1 is left, -1 right."""

    def job(self, free: object, tick: Sensed) -> None:
        """Nothing is planned."""

    def take(self, legs: object) -> None:
        """Nothing was planned."""

    def ask_again(self) -> None:
        """Nothing is planned that could be lost."""

    def plan_anew(self) -> None:
        """What the walls are does not matter."""

    def cancel(self, reason: str) -> None:
        """End it."""
        if self.status.active:
            self._show("canceled", reason)

    def hold(self, tick: Sensed) -> None:
        """Stand in this tick, since nobody renews the journey."""
        self._show("waiting", "nothing is heard from its sender: it waits")

    def step(self, tick: Sensed) -> Twist2:
        """Return the twist to command in this tick."""
        if not self.status.active:
            return Twist2()
        if not self.status.planned:
            self.status = replace(self.status, planned=tick.stamp)
        if tick.view is not None and tick.view is not self._newest:
            self._newest = tick.view
            self._look(tick.view)
        target = self._target(tick.odom)
        if target is not None:
            self._blind_since = None
            self._show("driving", "")
            return self._pursue(*target)
        if self._blind_since is None:
            self._blind_since = tick.stamp
        blind = tick.stamp - self._blind_since
        if self._follows and blind < 3 * SEARCH_S:
            self._show("waiting", "it looks where the tape goes on")
            first = blind < SEARCH_S
            return Twist2(0.0, SEARCH_RAD * (self._side if first else -self._side))
        if self._follows:
            self._show("arrived", "")
        elif blind < BLIND_S:
            self._show("waiting", "it sees no tape")
        else:
            self._show("failed", "no tape is in sight; valid is tape before the camera")
        return Twist2()

    def _look(self, view: Glimpse) -> None:
        """Remember the tape in a view."""
        odom_from_robot = view.odom_from_robot
        seen = odom_from_robot.apply(tape_in(view.scan, edges=True))
        tape = np.concatenate([seen, *(each for _, each in self._seen)])
        for been, _ in self._seen:
            tape = tape[np.hypot(tape[:, 0] - been.x, tape[:, 1] - been.y) > PASSED_M]
        self._tape = tape
        last = self._seen[-1][0] if self._seen else None
        if (
            last is None
            or last.distance_to(odom_from_robot) > APART_M
            or abs(last.turn_to(odom_from_robot)) > APART_RAD
        ):
            self._seen.append((odom_from_robot, seen))

    def _target(self, odom: Pose2) -> tuple[float, float] | None:
        """Return where to drive, in the robot's frame [m]; None without tape ahead."""
        points = odom.inverse().apply(self._tape)
        away, side = np.hypot(*points.T), np.abs(np.arctan2(points[:, 1], points[:, 0]))
        around = points[(away > NEAR_M) & (away < FAR_M) & (side < SIDE_RAD)]
        if len(around):
            self._follows = True
            bearing = np.arctan2(around[:, 1], around[:, 0])
            ahead = int(np.argmin(np.abs(bearing - self._straight_on(odom))))
            near = np.hypot(*(around - around[ahead]).T) < WIDE_M
            same = around[near & (np.abs(bearing - bearing[ahead]) < SAME_RAD)]
            x, y = same.mean(axis=0).tolist()
            return x, y
        most, most_side = (GAP_M, SIDE_RAD) if self._follows else (BEGINS_M, TURNS_RAD)
        farther = points[(away >= FAR_M) & (away < most) & (side < most_side)]
        if not len(farther):
            return None
        x, y = farther[np.argmin(np.hypot(*farther.T))].tolist()
        return x, y

    def _straight_on(self, odom: Pose2) -> float:
        """Return the bearing in which it would go straight on, by where it came from [rad]."""
        came = next(
            (been for been, _ in reversed(self._seen) if been.distance_to(odom) > BACK_M), None
        )
        if came is None:
            return 0.0
        back = odom.inverse().apply(np.array([[came.x, came.y]]))[0]
        return min(max(math.atan2(-back[1], -back[0]), -MOST_BACK_RAD), MOST_BACK_RAD)

    def _pursue(self, x: float, y: float) -> Twist2:
        """Return the twist along the arc that leads to a point in the robot's frame [m]."""
        bearing = math.atan2(y, x)
        self._side = math.copysign(1.0, bearing)
        if abs(bearing) > TURNS_RAD:
            return Twist2(0.0, math.copysign(min(1.0, self._limits.turning), bearing))
        bend = 2 * y / (x * x + y * y)
        speed = self._speed / (1 + abs(bend) * BEND_M)
        speed = min(speed, self._limits.turning / max(abs(bend), 1e-9))
        return Twist2(speed, speed * bend)

    def _show(self, state: NavigationState, reason: str) -> None:
        self.status = replace(self.status, state=state, reason=reason)
