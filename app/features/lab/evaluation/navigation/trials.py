"""NavigationTrial: journeys of one simulated robot, stepped without a clock, and their truth."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from app.engine.build import build_program
from app.engine.robots import robot_spec
from app.engine.snapshot import Snapshot
from app.features.lab.evaluation.drives import for_lab, silent
from app.features.lab.evaluation.experiment import KNOWN
from app.features.lab.evaluation.integrity.claims import entries_over
from app.features.navigation.messages import CurveMessage, GoalMessage, NavigateCommand
from app.messages.commands import Command
from app.messages.driving_commands import FigureEightCommand, StopCommand
from app.settings.config import MAPS, Config
from robot.driving.drive_controller import DriveSettings
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2
from robot.interface import RepositionableRobot
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.navigation_status import NavigationStatus
from robot.navigation.next_way import Approach, Planning, way_to
from robot.navigation.planners import find_way
from robot.navigation.planning import NoWayError
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits

TRIALS = ("goals", "pushed", "carried", "scattered", "figure-eight", "open-loop")
"""What is tried: random goals one after the other; the same, pushed by 0.2 m on the way, or carried
off by 0.5 m; a goal at once for a robot that may be anywhere; the figure-eight by the estimate, and
without."""
GOALS = 11
"""Number of the random stream, beside the seed, that goals and pushes are drawn from."""
PUSH_M = {"pushed": 0.2, "carried": 0.5}
"""How far the robot is moved on its way [m]."""
PUSHED_AT = (0.2, 0.7)
"""Shares of the time of a journey between which it is moved."""
TRIES = 400
"""So many places are drawn for one goal or one push, until the robot fits there."""
LONGEST_S = 120.0
"""A journey that takes longer has not arrived [s]."""
AFTER_S = 0.3
"""The truth is read so long after the end [s]."""
BEGINS_S = 1.0
"""The robot stands so long before its first goal [s]."""
SHORTEST_M = 0.1
"""A goal is at least so far from the one before [m]."""
LEAVES_M = 0.05
"""A robot whose middle is so far beyond the tape has left the field [m]."""
RENEWAL = NavigateCommand(type="navigate")
COLUMNS = (
    "stamp", "true_x", "true_y", "true_theta", "x", "y", "theta", "state", "radius", "goal_x",
    "goal_y", "goal_theta", "path_x", "path_y", "navigation", "room",
)  # fmt: skip
"""Of a robot's CSV, a line a tick: truth, estimate and what is claimed of it, the goal, the point
where the robot shall be, what navigation shows, and the true outline's room [m, rad]."""
Row = dict[str, Any]


class NavigationTrial:
    """One robot, which knows its place at the start unless it is scattered."""

    def __init__(self, config: Config, trial: str) -> None:
        """Build the robot on its field; ``trial`` is one of ``TRIALS``."""
        field = load_field(config.map, MAPS)
        self.settings: NavigationSettings = config.group("navigation", NavigationSettings())
        self.rng = np.random.default_rng([config.seed, GOALS])
        self.config, self.trial, self.field = config, trial, field
        self.free = FreeSpace.of(field, robot_spec(config).outline, self.settings)
        if trial == "scattered":
            self.field = field = replace(field, start=self._free_pose())
        self.program = build_program(
            for_lab(config), field=field, entries=entries_over(field, config)
        )
        self.engine = silent(self.program.engine)
        self.now: Snapshot = self.engine.step()
        self._room, self._began, self._was_moved = math.inf, 0.0, False
        self._was_clear = False
        """Whether it was clear of tape since it was put to its place: else it did not go there."""
        self.ticks: list[list[str]] = []
        localization = self.engine.localization
        if trial == "scattered":
            localization.scatter()
            return
        error = self.rng.normal(0, np.sqrt(np.diag(KNOWN)))
        given = Pose2.from_array(self.truth.to_array() + error)
        localization.set_pose(given, KNOWN)
        self._run(BEGINS_S)

    @property
    def truth(self) -> Pose2:
        """Where the robot is."""
        assert self.now.truth is not None
        return self.now.truth

    def close(self) -> None:
        """End the robot, and what goes along."""
        over = threading.Event()
        over.set()
        self.engine.run(over)

    def journey(self, number: int) -> Row:
        """Drive to one random goal, and return what was seen of it."""
        start = self.truth
        goal = self._goal(start)
        if goal is None:
            return {
                "number": number,
                "state": "no goal",
                "reason": "none was found",
                "room_m": None,
            }
        fastest = self._fastest(goal)
        moved = self._moves_at(fastest)
        self._room = math.inf
        message = GoalMessage(x=goal.x, y=goal.y, theta=goal.theta)
        status = self._drive(NavigateCommand(type="navigate", poses=[message]), LONGEST_S, moved)
        seconds = self.now.stamp - self._began
        self._run(AFTER_S)
        truth, pose = self.truth, self.now.pose
        return {
            "number": number,
            "goal": goal.to_array().tolist(),
            "start": start.to_array().tolist(),
            "state": status.state if status else "none",
            "reason": status.reason if status else "",
            "seconds": seconds,
            "fastest_s": fastest,
            "error_m": truth.distance_to(goal),
            "turn_rad": abs(truth.turn_to(goal)),
            "claimed_m": None if pose is None else pose.distance_to(goal),
            "estimate_m": None if pose is None else pose.distance_to(truth),
            "bound_m": _finite(self.now.integrity.radius),
            "room_m": _finite(self._room),
            "moved": self._was_moved,
        }

    def curve(self, seconds: float) -> Row:
        """Drive the figure-eight for some time [s], and return how far the truth is from it."""
        start, radius = self.field.start, self.config.figure_eight.radius
        self._room = math.inf
        place = GoalMessage(x=start.x, y=start.y, theta=start.theta)
        command: Command = FigureEightCommand(type="figure_eight")
        if self.trial == "figure-eight":
            curve = CurveMessage(shape="figure_eight", start=place)
            command = NavigateCommand(type="navigate", curve=curve)
        offsets: list[float] = []
        left = None
        began = self.now.stamp
        self._put(command)
        while self.now.stamp < began + seconds:
            self._step(command if self.trial == "open-loop" else RENEWAL)
            status = self._status
            if self.trial == "figure-eight" and (status is None or not status.active):
                break
            place_now = np.array([[self.truth.x, self.truth.y]])
            offsets.append(_from_circles(start.inverse().apply(place_now), radius))
            if self.field.farthest_outside(place_now) > LEAVES_M:
                left = self.now.stamp - began
                break
        minutes = np.array_split(np.square(offsets), max(1, round((self.now.stamp - began) / 60)))
        rms = [float(np.sqrt(each.mean())) for each in minutes if len(each)]
        return {
            "number": 0,
            "state": "left the field" if left else "driven",
            "reason": "",
            "seconds": self.now.stamp - began,
            "rms_m": float(np.sqrt(np.mean(np.square(offsets)))),
            "worst_m": float(np.max(offsets)),
            "rms_by_minute_m": rms,
            "room_m": _finite(self._room),
            "moved": False,
        }

    def _goal(self, start: Pose2) -> Pose2 | None:
        """Return a goal that there is a way to; None if none was found."""
        for _ in range(TRIES):
            goal = self._free_pose()
            if goal.distance_to(start) >= SHORTEST_M and self._has_way(start, goal):
                return goal
        return None

    def _free_pose(self) -> Pose2:
        xmin, ymin, xmax, ymax = self.field.drive_area
        for _ in range(TRIES):
            x, y = self.rng.uniform(xmin, xmax), self.rng.uniform(ymin, ymax)
            pose = Pose2(float(x), float(y), float(self.rng.uniform(-math.pi, math.pi)))
            if self.free.fits(pose.to_array()[None]):
                return pose
        return self.field.start

    def _fastest(self, goal: Pose2) -> float:
        """Return the time [s] of the fastest drive within the limits along the way it takes."""
        kinematics = self.engine.controls.driving.kinematics
        wheels = (kinematics.left, kinematics.right)
        rim = min(
            kinematics.spec.joints[each].max_velocity * kinematics.radii[each] for each in wheels
        )
        limits = _all_of(self.config.drive, self.settings, float(rim), kinematics.track)
        start, bound = self.now.pose or self.truth, self.now.integrity.radius
        approach = Approach(start, Goal(*goal.to_array().tolist()), bound=bound)
        try:
            way = way_to(self.free, approach, Planning(find_way, self.settings, limits))
        except NoWayError:
            return 0.0
        return 0.0 if way is None else way.duration - way.rest_s

    def _moves_at(self, fastest: float) -> float | None:
        if self.trial not in PUSH_M:
            return None
        return self.now.stamp + fastest * float(self.rng.uniform(*PUSHED_AT))

    def _drive(
        self, command: NavigateCommand, longest: float, moved_at: float | None
    ) -> NavigationStatus | None:
        """Drive until the journey is over."""
        self._began, self._was_moved = self.now.stamp, False
        self._put(command)
        status = None
        while self.now.stamp < self._began + longest:
            self._step(RENEWAL)
            status = self._status
            if status is not None and not status.active and self.now.stamp > self._began + 0.1:
                return status
            if moved_at is not None and self.now.stamp >= moved_at:
                moved_at = None
                self._was_moved = self._move(PUSH_M[self.trial], command)
        self._put(StopCommand(type="stop"))
        return status

    @property
    def _status(self) -> NavigationStatus | None:
        """What navigation shows of itself; None before the first journey."""
        status: NavigationStatus | None = self.now.added.get("navigation")
        return status

    def _move(self, distance: float, command: NavigateCommand) -> bool:
        """Move the robot, unseen, to where it fits and can drive to its goal; False if nowhere.

        From outside of a ring of tape it could arrive only by crossing it.
        """
        assert command.poses is not None
        goal = command.poses[0]
        wanted = Pose2(goal.x, goal.y, goal.theta or 0.0)
        robot = self.program.robot
        assert isinstance(robot, RepositionableRobot)
        for _ in range(TRIES):
            bearing, turn = self.rng.uniform(-math.pi, math.pi), self.rng.normal(0, 0.3)
            moved = Pose2(distance * math.cos(bearing), distance * math.sin(bearing), float(turn))
            place = self.truth @ moved
            if self.free.fits(place.to_array()[None]) and self._has_way(place, wanted):
                robot.place(place)
                self._was_clear = False
                return True
        return False

    def _has_way(self, start: Pose2, goal: Pose2) -> bool:
        try:
            find_way(self.free, start, goal)
        except NoWayError:
            return False
        return True

    def _run(self, seconds: float) -> None:
        until = self.now.stamp + seconds
        while self.now.stamp < until:
            self._step(None)

    def _put(self, command: Command) -> None:
        self.engine.commands.put(command)

    def _step(self, command: Command | None) -> None:
        if command is not None:
            self._put(command)
        self.now = self.engine.step()
        room = float(self.free.room(self.truth.to_array()[None])[0])
        self._was_clear = self._was_clear or room > 0
        if self._was_clear:
            self._room = min(self._room, room)
        self.ticks.append(self._tick(room))

    def _tick(self, room: float) -> list[str]:
        """Return one line of the CSV."""
        snapshot, status = self.now, self._status
        goal: tuple[float | None, ...] = (None, None, None)
        target = None
        if status is not None and status.active:
            goal = status.goals[status.number] if status.goals else goal
            target = status.target
        numbers = (
            snapshot.stamp, *self.truth.to_array(), *_numbers(snapshot.pose),
            snapshot.integrity.radius, *goal,
            *_numbers(target)[:2],
        )  # fmt: skip
        shown = ["" if each is None else f"{each:.6f}" for each in numbers]
        state = "" if status is None else status.state
        return [*shown[:7], str(snapshot.integrity.state), *shown[7:], state, f"{room:.4f}"]


def _all_of(drive: DriveSettings, settings: NavigationSettings, rim: float, track: float) -> Limits:
    """Return the limits with nothing left for a controller."""
    return Limits(
        speed=min(settings.desired_linear_vel, drive.max_velocity),
        gain=drive.max_acceleration,
        loss=drive.max_deceleration,
        turning=min(settings.rotate_to_heading_angular_vel, drive.max_angular_velocity),
        turning_gain=min(settings.max_angular_accel, drive.max_angular_acceleration),
        rim=rim,
        half_track=track / 2,
    )


def _from_circles(place: Array, radius: float) -> float:
    """Return how far a place (1, 2) is from the two circles of a radius that touch at (0, 0)."""
    return min(abs(math.hypot(place[0, 0], place[0, 1] - y) - radius) for y in (radius, -radius))


def _numbers(pose: Pose2 | None) -> tuple[float | None, ...]:
    return (None, None, None) if pose is None else (pose.x, pose.y, pose.theta)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


@dataclass(frozen=True)
class NavigationJob:
    """The journeys of one robot."""

    config: Config
    condition: str
    trial: str
    goals: int
    minutes: float


@dataclass(frozen=True)
class NavigationRun:
    """What one robot has done."""

    rows: list[Row]
    """Its journeys' rows in ``results.json``."""
    ticks: list[list[str]]
    """The lines of its CSV, by ``COLUMNS``."""


def do_trial(job: NavigationJob) -> NavigationRun:
    """Do one robot's journeys; equal jobs have equal outcomes."""
    trial = NavigationTrial(job.config, job.trial)
    try:
        if job.trial in ("figure-eight", "open-loop"):
            return NavigationRun([trial.curve(60 * job.minutes)], trial.ticks)
        goals = 1 if job.trial == "scattered" else job.goals
        return NavigationRun([trial.journey(number) for number in range(goals)], trial.ticks)
    finally:
        trial.close()
