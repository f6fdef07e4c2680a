"""Navigator: drives a robot from goal to goal, tick by tick; it says what it does and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2, Twist2, wrap_angle
from robot.localization.estimate import KNOWN, Integrity, State
from robot.navigation.controllers import PathController, Tracker, Tracking
from robot.navigation.curves import ClosedCurve, Lap, lap_of
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.legs import WayLeg, curve, straight, turn
from robot.navigation.looking_around import Look, LookingAround
from robot.navigation.lookout import Move
from robot.navigation.planners import find_way
from robot.navigation.planning import NoWayError, Planner, comes_no_nearer
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits, TimedWay, timed, timed_loop
from robot.navigation.tracker import follow

NavigationState = Literal["planning", "driving", "waiting", "arrived", "canceled", "failed"]
SETTLE_S = 0.4
"""The robot stands so long before its end is judged: the filter sees it at rest [s]."""
GOAL_STAYS = 0.015
"""A place that was reached counts so until the robot is farther away from it [m]."""
MOST_CORRECTIONS = 6
"""So often an end that is too far from its goal is driven to again; then the journey has failed."""
CORRECTIONS_M = (-0.08, 0.08, -0.04, 0.04, -0.025, 0.025)
"""For that the robot goes back so far, or ahead, and comes again [m]: the first that has room."""
SMALL_TURN, SWING = 0.02, 0.25
"""For a turn smaller than the first it swings away by the second, and comes again [rad]."""
SIDESTEPS = 25
"""Points of the way back."""
VAGUE_M = 0.035
"""At a goal where its bound is wider than this, the robot turns around once to see more [m]."""
SLOWEST = 0.25
"""Share of its speed that the robot keeps while its bound is wide."""
DOUBT_S = 1.0
"""It stands still while its place is in doubt for less than this, and then looks around [s]. It
drives on slowly while the bound is only wide."""
UNSURE = {
    State.AMBIGUOUS: "several places look alike",
    State.SEARCHING: "it does not know where it is",
    State.LOST: "it is lost",
}

SEARCHED_S = 1.0
"""The nearest place on a leg is looked for so far ahead [s]."""
LEG_ENDS_M, LEG_ENDS_S = 0.006, 0.5
"""A controller that does not keep times has come to the end of its leg so near to it [m], or if it
stands so shortly before it [s]; the rest is driven by times."""
ON_CURVE = 0.02
"""A robot that is farther from a closed curve first drives to it as to a goal [m; rad / 5]."""

Plan = tuple[WayLeg, ...] | Lap | Move
Job = Callable[[], Plan]
"""Plans; raises a ``NoWayError``."""


@dataclass(frozen=True, eq=False)
class NavigationStatus:
    """What navigation shows of itself."""

    state: NavigationState
    goals: tuple[Goal, ...]
    name: str | int | None = None
    """By which its sender knows it."""
    number: int = 0
    """Number of the goal that it drives to, from 0."""
    reason: str = ""
    """Why it stands or has failed, in words for people; empty while all is well."""
    remaining_m: float = 0.0
    """The way to this goal [m]."""
    remaining_s: float = 0.0
    """How long it takes to this goal [s]."""
    target: Pose2 | None = None
    """Where the robot shall be next."""
    path: Array | None = field(default=None, repr=False)
    """(n, 2) the way to this goal [m]."""
    planned: float = 0.0
    """When that way was taken [s]: another one has another time."""
    on_curve: bool = False
    """Whether it drives along a closed curve, or to it; then there are no goals."""

    @property
    def active(self) -> bool:
        """Whether the robot drives, or will."""
        return self.state in ("planning", "driving", "waiting")


class Navigator:
    """One journey: to a goal, or to several one after the other."""

    def __init__(
        self,
        goals: tuple[Goal, ...],
        settings: NavigationSettings,
        limits: Limits,
        *,
        look: Look,
        name: str | int | None = None,
        repeat: bool = False,
        curve: ClosedCurve | None = None,
        planner: Planner = find_way,
        controller: PathController | None = None,
    ) -> None:
        """Begin a journey.

        Args:
            goals: one or more; none with a curve.
            settings: tolerances and speeds.
            limits: of the drive.
            look: finds moves for a robot that does not know its place; in another thread.
            name: by which its sender knows the journey.
            repeat: whether it begins again after the last goal.
            curve: is driven lap after lap, until somebody ends it.
            planner: finds ways.
            controller: drives along them; none is the tracker.
        """
        self.status = NavigationStatus("planning", goals, name, on_curve=curve is not None)
        self._settings = settings
        self._limits = limits
        self._lookout = LookingAround(look, limits, settings)
        self._repeat = repeat
        self._planner = planner
        self._controller = controller or Tracker()
        self._curve = curve
        self._lap: Lap | None = None
        """Of the curve, as it lies in the map; None before it is known."""
        self._trajectory: TimedWay | None = None
        self._clock = 0.0
        """How far the trajectory is driven [s]."""
        self._stamp: float | None = None
        self._stands_since: float | None = None
        self._ended: float | None = None
        """When the trajectory was over [s]; None before that."""
        self._asked: Pose2 | None = None
        """Where the way begins that is planned now; None if none is."""
        self._doubted_since: float | None = None
        self._corrections = 0
        self._seeks = self._sought = False
        """Whether it shall turn around at the goal, and whether it has."""
        self._reached = False
        """Whether the place of the goal was reached: then only the heading is left."""
        self._left_at: Pose2 | None = None
        """Where the robot left its curve; there it goes on."""

    def job(self, free: Callable[[], FreeSpace], tick: Sensed) -> Job | None:
        """Return work for another thread, if there is some: its result belongs to ``take``."""
        if self._asked is not None:
            return None
        if self._lookout.active:
            search = self._lookout.job(tick)
            self._asked = None if search is None else tick.odom
            return search
        if self.status.state != "planning" or tick.pose is None or not tick.stands:
            return None
        if self._curve is not None:
            return self._curve_job(self._curve, free, tick.pose)
        start, goal, planner = tick.pose, self._goal, self._planner
        reached, settings, seeks = self._reached, self._settings, self._seeks
        self._seeks = False
        self._asked = start

        def work() -> tuple[WayLeg, ...]:
            space = free()
            if goal.theta is None:
                theta = math.atan2(goal.y - start.y, goal.x - start.x)
                end = Pose2(goal.x, goal.y, theta)
            else:
                end = Pose2(goal.x, goal.y, goal.theta)
            if seeks and space.turns(start.to_array()[None, :2]):
                return _all_around(start)
            if reached and start.distance_to(end) <= GOAL_STAYS:
                legs = corrected(space, start, end, settings)
                # Without room to correct it, an end beside the goal is no arrival: it comes anew.
                if legs or _is_there(start, end, settings):
                    return legs
            return planner(space, start, end)

        return work

    def _curve_job(
        self, wanted: ClosedCurve, free: Callable[[], FreeSpace], start: Pose2
    ) -> Job | None:
        """Return the work of a curve: a way to it, or the lap if the robot stands on it."""
        lap = self._lap or lap_of(wanted, wanted.start or start, self._limits)
        self._lap = lap = lap.begun_near(self._left_at or start)
        planner, begin = self._planner, lap.begin
        self._asked = start

        def work() -> Plan:
            space = free()
            if not space.fits(lap.poses):
                raise NoWayError(
                    "along the curve the robot would touch a wall, or be nearer to it than "
                    f"{1000 * space.settings.clearance:.0f} mm; valid is a smaller one, or "
                    "another place to begin"
                )
            turned = abs(begin.turn_to(start)) / 5
            if max(begin.distance_to(start), turned) <= ON_CURVE:
                return lap
            return planner(space, start, begin)

        return work

    def take(self, legs: Plan | BrickPoseError) -> None:
        """Drive along legs that were planned, or stand if there is no way."""
        self._asked = None
        if not self.status.active:
            return
        if isinstance(legs, Move):
            self._lookout.take(legs, self._stamp or 0.0)
            return
        if isinstance(legs, BrickPoseError):
            self._end("failed", str(legs))
            return
        self._clock = 0.0
        self._stands_since = None
        if not legs:
            self._trajectory = None
            self._next_goal()
            return
        if isinstance(legs, Lap):
            self._trajectory = timed_loop(legs.legs, self._limits)
        else:
            self._trajectory = timed(legs, self._limits)
        self.status = replace(
            self.status, path=self._trajectory.lap_points, planned=self._stamp or 0.0
        )
        self._show("driving")

    def step(self, tick: Sensed) -> Twist2:
        """Return the twist to command in this tick."""
        passed = 0.0 if self._stamp is None else max(tick.stamp - self._stamp, 0.0)
        self._stamp = tick.stamp
        trajectory, pose = self._trajectory, tick.pose
        if not self.status.active or self._asked is not None:
            return Twist2()
        doubt = self._doubt(tick)
        if doubt and self._doubted_since is None:
            self._doubted_since = tick.stamp
        elif not doubt:
            self._doubted_since = None
        if pose is None or self._lookout.active or self._has_to_look(tick):
            return self._look_around(tick, doubt, passed)
        if trajectory is None or self._stays(tick, pose, trajectory, doubt):
            return Twist2()
        if self._clock >= trajectory.duration and self._settled(tick, pose, trajectory):
            return Twist2()
        return self._drive(tick, pose, trajectory, passed)

    def _stays(self, tick: Sensed, pose: Pose2, trajectory: TimedWay, doubt: str) -> bool:
        """Whether it must not drive on: its place is in doubt, or it is off its way."""
        if doubt and math.isinf(tick.integrity.radius):
            self._show("waiting", reason=doubt)
            return True
        if self._is_off(pose, trajectory):
            self.plan_anew()
            return True
        return False

    def _drive(self, tick: Sensed, pose: Pose2, trajectory: TimedWay, passed: float) -> Twist2:
        """Go on along the trajectory."""
        pace = self._pace(tick.integrity)
        low, high = trajectory.leg_at(self._clock)
        stays = trajectory.is_turn(low, high)
        controller = self._controller
        clock = min(self._clock + pace * passed, trajectory.duration)
        if not controller.by_time and not stays and self._clock < trajectory.duration:
            clock = self._clock_by_place(tick, pose, trajectory, clock, high)
        self._clock = clock
        wanted = trajectory.at(clock)
        ahead = trajectory.at(clock + pace * self._settings.command_lag).twist
        self._show("driving", target=wanted.pose)
        paced = Twist2(pace * ahead.v, pace * ahead.omega)
        over = clock >= trajectory.duration
        if stays or (over and not controller.by_time):
            return follow(pose, wanted, paced, self._settings)
        tracking = Tracking(
            pose,
            wanted,
            paced,
            trajectory.ahead_of(clock, high),
            trajectory.is_backwards(low, high),
            tick.twist,
            pace,
            self._settings,
        )
        try:
            return controller.command(tracking)
        except BrickPoseError as error:
            self._show("waiting", reason=str(error))
            return Twist2()

    def _clock_by_place(
        self, tick: Sensed, pose: Pose2, trajectory: TimedWay, latest: float, high: int
    ) -> float:
        """Return the time of the nearest place on the leg; at its end, time goes on by itself."""
        end = float(trajectory.times[high])
        nearest = trajectory.nearest_time(pose, self._clock, min(self._clock + SEARCHED_S, end))
        left = trajectory.at(end).pose.distance_to(pose)
        if left < LEG_ENDS_M or (end - nearest < LEG_ENDS_S and tick.stands):
            return latest if latest > end else end
        return nearest

    def hold(self, tick: Sensed) -> None:
        """Stand in this tick, since nobody renews the journey."""
        self._stamp = tick.stamp
        if self.status.state != "planning":
            self._stands_since = None
            self._show("waiting", reason="nothing is heard from its sender: it waits")

    @property
    def looks(self) -> bool:
        """Whether it finds out where it is."""
        return self._lookout.active

    def ask_again(self) -> None:
        """Have the way planned again whose result was lost."""
        self._asked = None

    def plan_anew(self) -> None:
        """Stand, and plan another way from there."""
        trajectory = self._trajectory
        if trajectory is not None and trajectory.loop is not None:
            self._left_at = trajectory.at(self._clock).pose
        self._trajectory = None
        self._lookout.give_up_move()
        self._stands_since = None
        self._show("planning")

    def cancel(self, reason: str) -> None:
        """End the journey before its goal."""
        if self.status.active:
            self._end("canceled", reason)

    @property
    def _goal(self) -> Goal:
        return self.status.goals[self.status.number]

    def _doubt(self, tick: Sensed) -> str:
        """Return in words why the robot does not know its place well enough; empty if it does."""
        if tick.pose is None or tick.integrity.state not in KNOWN:
            return UNSURE.get(tick.integrity.state, UNSURE[State.SEARCHING])
        radius = tick.integrity.radius
        if radius <= self._settings.stop_radius:
            return ""
        if math.isinf(radius):
            return "its place is in doubt"
        return f"its place is known to {100 * math.ceil(10 * radius)} mm only"

    def _has_to_look(self, tick: Sensed) -> bool:
        """Whether it does not know its place, or has not known it well for some time."""
        if self._doubted_since is None:
            return False
        return tick.integrity.state not in KNOWN or tick.stamp - self._doubted_since > DOUBT_S

    def _look_around(self, tick: Sensed, doubt: str, passed: float) -> Twist2:
        """Move so that the place becomes known; stand if that has not helped."""
        lookout = self._lookout
        if not lookout.active:
            lookout.begin(tick.stamp)
            self._trajectory = None
        self._stands_since = None
        if lookout.is_over(tick, doubt):
            self.plan_anew()
            return Twist2()
        self._show("waiting", reason=lookout.reason(doubt))
        return lookout.step(tick, passed)

    def _pace(self, integrity: Integrity) -> float:
        """Return the share of the planned speed that the robot drives."""
        slow, stop = self._settings.slow_radius, self._settings.stop_radius
        share = (stop - integrity.radius) / (stop - slow)
        return min(1.0, max(SLOWEST, share))

    def _is_off(self, pose: Pose2, trajectory: TimedWay) -> bool:
        wanted = trajectory.at(self._clock).pose
        return pose.distance_to(wanted) > self._settings.off_path

    def _settled(self, tick: Sensed, pose: Pose2, trajectory: TimedWay) -> bool:
        """Whether the robot has come to its end: it then stands, and goes on or comes again."""
        error = pose.inverse() @ trajectory.goal
        settings = self._settings
        is_there = abs(error.x) <= settings.xy_goal_tolerance / 2
        is_turned = abs(error.theta) <= settings.yaw_goal_tolerance / 2
        if self._stands_since is None:
            late = self._clock_since_end(tick) > 2.0
            if not (is_there and is_turned and tick.stands) and not late:
                return False
            self._stands_since = tick.stamp
        if tick.stamp - self._stands_since < SETTLE_S:
            return True
        self._judge(pose, trajectory.goal, tick.integrity.radius)
        return True

    def _clock_since_end(self, tick: Sensed) -> float:
        """Return how long the end of the trajectory is over [s]."""
        if self._ended is None:
            self._ended = tick.stamp
        return tick.stamp - self._ended

    def _judge(self, pose: Pose2, goal: Pose2, radius: float) -> None:
        settings = self._settings
        if self._curve is not None:  # it stands where the curve begins, or beside it
            self._ended = None
            self.plan_anew()
            return
        if radius > VAGUE_M and not self._sought:
            self._reached, self._ended = True, None
            self._seeks = self._sought = True
            self.plan_anew()
            return
        distance = pose.distance_to(goal)
        self._reached = True
        self._ended = None
        any_heading = self._goal.theta is None
        turned = (
            any_heading or abs(wrap_angle(goal.theta - pose.theta)) <= settings.yaw_goal_tolerance
        )
        if distance <= settings.xy_goal_tolerance and turned:
            self._next_goal()
            return
        if self._corrections >= MOST_CORRECTIONS:
            turn_off = 0.0 if any_heading else abs(wrap_angle(goal.theta - pose.theta))
            self._end("failed", _miss(distance, turn_off, settings))
            return
        self._corrections += 1
        self.plan_anew()

    def _next_goal(self) -> None:
        self._corrections, self._reached, self._ended = 0, False, None
        self._sought = False
        following = self.status.number + 1
        if following >= len(self.status.goals):
            if not self._repeat:
                self._end("arrived", "")
                return
            following = 0
        self.status = replace(self.status, number=following)
        self.plan_anew()

    def _end(self, state: NavigationState, reason: str) -> None:
        self._trajectory = None
        self.status = replace(
            self.status, state=state, reason=reason, remaining_m=0.0, remaining_s=0.0, target=None
        )

    def _show(
        self,
        state: NavigationState,
        *,
        reason: str = "",
        target: Pose2 | None = None,
    ) -> None:
        trajectory = self._trajectory
        left_m = left_s = 0.0
        if trajectory is not None:
            left_m = trajectory.left_at(self._clock)
            left_s = trajectory.time_left(self._clock)
        self.status = replace(
            self.status,
            state=state,
            reason=reason,
            target=target,
            remaining_m=left_m,
            remaining_s=left_s,
        )


def _miss(distance: float, turn_off: float, settings: NavigationSettings) -> str:
    """Return in words how far from its goal the robot stands after all corrections."""
    return (
        f"it stands {1000 * distance:.1f} mm and {math.degrees(turn_off):.1f} degrees beside the "
        f"goal and comes no nearer; valid is a xy_goal_tolerance above "
        f"{1000 * settings.xy_goal_tolerance:.1f} mm, or a yaw_goal_tolerance above "
        f"{math.degrees(settings.yaw_goal_tolerance):.1f} degrees"
    )


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


def _is_there(pose: Pose2, goal: Pose2, settings: NavigationSettings) -> bool:
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


def _all_around(pose: Pose2) -> tuple[WayLeg, ...]:
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
