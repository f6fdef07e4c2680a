"""Navigator: drives a robot from goal to goal, tick by tick; it says what it does and why."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from robot.errors import BrickPoseError
from robot.geometry import Pose2, Twist2
from robot.localization.estimate import KNOWN, Integrity, State
from robot.navigation.arrival import Arrival, WayEnd
from robot.navigation.controllers import PathController, Tracker, Tracking
from robot.navigation.curves import ClosedCurve, Lap, lap_of
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.looking_around import Look, LookingAround
from robot.navigation.lookout import Move
from robot.navigation.navigation_status import NavigationState, NavigationStatus
from robot.navigation.next_way import Approach, Planning, way_onto, way_to
from robot.navigation.planners import find_way
from robot.navigation.planning import Planner
from robot.navigation.sensed import Sensed
from robot.navigation.settings import REFUSED, NavigationSettings
from robot.navigation.timed_way import Limits, TimedWay
from robot.navigation.tracker import follow

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

Plan = TimedWay | Move | None
"""A way, or a move of a robot that does not know its place; None: it is there."""
Job = Callable[[], Plan]
"""Plans; raises a ``NoWayError``."""


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
        self._planning = Planning(planner, settings, limits)
        self._lookout = LookingAround(look, limits, settings)
        self._arrival = Arrival(settings)
        self._repeat = repeat
        self._controller = controller or Tracker()
        self._curve = curve
        self._lap: Lap | None = None
        """Of the curve, as it lies in the map; None before it is known."""
        self._trajectory: TimedWay | None = None
        self._clock = 0.0
        """How far the trajectory is driven [s]."""
        self._stamp: float | None = None
        self._asked = False
        """Whether a way, or a move, is worked out now."""
        self._doubted_since: float | None = None
        self._left_at: Pose2 | None = None
        """Where the robot left its curve; there it goes on."""

    def job(self, free: Callable[[], FreeSpace], tick: Sensed) -> Job | None:
        """Return work for another thread, if there is some: its result belongs to ``take``."""
        if self._asked:
            return None
        if self._lookout.active:
            job: Job | None = self._lookout.job(tick)
        elif self.status.state != "planning" or tick.pose is None or not tick.stands:
            return None
        elif tick.integrity.state not in KNOWN:
            return None  # from a wrong place there may be no way: first it looks around
        elif self._refuses and tick.integrity.radius > self._settings.stop_radius:
            return None  # no way has room for that
        elif self._curve is not None:
            job = self._curve_job(self._curve, free, tick.pose, tick.integrity.radius)
        else:
            job = self._goal_job(free, tick.pose, tick.integrity.radius)
        self._asked = job is not None
        return job

    def _goal_job(self, free: Callable[[], FreeSpace], start: Pose2, bound: float) -> Job:
        arrival, planning = self._arrival, self._planning
        approach = Approach(start, self._goal, arrival.reached, arrival.seeks, bound)
        arrival.seeks = False
        return lambda: way_to(free(), approach, planning)

    def _curve_job(
        self, wanted: ClosedCurve, free: Callable[[], FreeSpace], start: Pose2, bound: float
    ) -> Job:
        lap = self._lap or lap_of(wanted, wanted.start or start, self._planning.limits)
        self._lap = lap = lap.begun_near(self._left_at or start)
        return lambda: way_onto(free(), start, lap, self._planning, bound)

    @property
    def _refuses(self) -> bool:
        """Whether its outline grown by its bound must come to no wall."""
        return self._settings.narrow_ways == REFUSED

    def take(self, plan: Plan | BrickPoseError) -> None:
        """Drive along a way that was planned, or stand if there is none."""
        self._asked = False
        if not self.status.active:
            return
        if isinstance(plan, Move):
            self._lookout.take(plan, self._stamp or 0.0)
            return
        if isinstance(plan, BrickPoseError):
            self._end("failed", str(plan))
            return
        self._clock = 0.0
        self._arrival.leave()
        self._trajectory = plan
        if plan is None:
            self._next_goal()
            return
        self.status = replace(self.status, path=plan.lap_points, planned=self._stamp or 0.0)
        self._show("driving")

    def step(self, tick: Sensed) -> Twist2:
        """Return the twist to command in this tick."""
        passed = 0.0 if self._stamp is None else max(tick.stamp - self._stamp, 0.0)
        self._stamp = tick.stamp
        trajectory, pose = self._trajectory, tick.pose
        if not self.status.active or self._asked:
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
        if self._is_off(pose, trajectory) or self._comes_too_near(tick, trajectory):
            self.plan_anew()
            return True
        return False

    def _comes_too_near(self, tick: Sensed, trajectory: TimedWay) -> bool:
        """Whether its bound has grown beyond the room on its way, and that is refused."""
        room = max(trajectory.bound, trajectory.room_at(self._clock))
        return self._refuses and tick.integrity.radius > room

    def _drive(self, tick: Sensed, pose: Pose2, trajectory: TimedWay, passed: float) -> Twist2:
        """Go on along the trajectory."""
        pace = self._pace(tick.integrity, trajectory)
        low, high = trajectory.leg_at(self._clock)
        stays = trajectory.is_turn(low, high)
        controller = self._controller
        before, clock = self._clock, min(self._clock + pace * passed, trajectory.duration)
        if not controller.by_time and not stays and self._clock < trajectory.duration:
            clock = self._clock_by_place(tick, pose, trajectory, clock, high)
        self._clock = clock
        wanted = trajectory.at(clock)
        ahead = trajectory.at(clock + pace * self._settings.command_lag).twist
        self._show("driving", target=wanted.pose, reason=trajectory.narrow)
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
            # The way waits too: else the robot would be off it, and hide the reason by planning.
            self._clock = before
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
            self._arrival.leave()
            self._show("waiting", reason="nothing is heard from its sender: it waits")

    @property
    def looks(self) -> bool:
        """Whether it finds out where it is."""
        return self._lookout.active

    def ask_again(self) -> None:
        """Have the way planned again whose result was lost."""
        self._asked = False

    def plan_anew(self) -> None:
        """Stand, and plan another way from there."""
        trajectory = self._trajectory
        if trajectory is not None and trajectory.loop is not None:
            self._left_at = trajectory.at(self._clock).pose
        self._trajectory = None
        self._lookout.give_up_move()
        self._arrival.leave()
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
        self._arrival.leave()
        if lookout.is_over(tick, doubt):
            self.plan_anew()
            return Twist2()
        self._show("waiting", reason=lookout.reason(doubt))
        return lookout.step(tick, passed)

    def _pace(self, integrity: Integrity, trajectory: TimedWay) -> float:
        """Return the share of the planned speed that the robot drives.

        Its outline grown by its bound comes to walls by so much as the bound is wider than the
        room on the way: where that is nothing, it need not be slower.
        """
        slow, stop = self._settings.slow_radius, self._settings.stop_radius
        beyond = integrity.radius - trajectory.room_at(self._clock)
        return min(1.0, max(SLOWEST, (stop - beyond) / (stop - slow)))

    def _is_off(self, pose: Pose2, trajectory: TimedWay) -> bool:
        wanted = trajectory.at(self._clock).pose
        return pose.distance_to(wanted) > self._settings.off_path

    def _settled(self, tick: Sensed, pose: Pose2, trajectory: TimedWay) -> bool:
        """Whether the robot has come to its end: it then stands, and goes on or comes again."""
        if not self._arrival.stands(tick, pose, trajectory.goal):
            return False
        if self._arrival.has_settled(tick.stamp):
            self._judge(pose, tick)
        return True

    def _judge(self, pose: Pose2, tick: Sensed) -> None:
        """Go on to the next goal, or come again to this one."""
        if self._curve is not None:  # it stands where the curve begins, or beside it
            self.plan_anew()
            return
        end = self._arrival.judge(pose, self._goal, tick)
        if end is WayEnd.THERE:
            self._next_goal()
        elif end is WayEnd.AGAIN:
            self.plan_anew()
        else:
            self._end("failed", self._arrival.miss(pose, self._goal))

    def _next_goal(self) -> None:
        vagueness = self._arrival.vagueness
        self._arrival.begin()
        following = self.status.number + 1
        if following >= len(self.status.goals):
            if not self._repeat:
                self._end("arrived", vagueness)
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
