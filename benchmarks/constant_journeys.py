"""Trials of a constant of navigation: journeys of robots that know where they are, and doubt it.

A navigator drives by itself, without an engine: wheels turn late, slip, and stand where they are
told to turn very slowly; the estimate errs as a filter's does. Some journeys are of another planner
or controller, some of a robot that is pushed, in doubt, or sure of little.
"""

from __future__ import annotations

import math
import pickle
import zlib
from collections import deque
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.driving.drive_controller import DriveSettings
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from robot.localization.estimate import Integrity, State
from robot.navigation.controllers import PathController, RegulatedPurePursuit, Tracker
from robot.navigation.curves import ClosedCurve
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.legs import turn
from robot.navigation.lookout import Move
from robot.navigation.navigator import Navigator, Plan
from robot.navigation.planners import PLANNERS
from robot.navigation.planning import NoWayError, Planner
from robot.navigation.possible_places import Glimpse
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits
from robot.scan import Scan

FIELD = "town"
SEED = 60500
ROUNDS = 3
"""How often each kind of journey is driven."""
KINDS = (
    "usual", "usual", "usual", "lattice", "rrt", "pursuit", "in doubt", "unsure", "pushed", "blind",
    "curve",
)  # fmt: skip
TICK = 0.02
LONGEST_S = 40.0
CURVE_S, CIRCLE_M, CURVE_SPEED = 25.0, 0.06, 0.1
"""A circle is driven for so long [s], of this radius [m], so fast [m/s]."""
PLANNED_S = 0.06
"""A way is there so long after it was asked for [s]."""
RIM, TRACK = 0.39, 0.112
"""Of the wheels: highest speed [m/s], and their distance [m]."""
SLIP, SLOWEST = 0.03, 0.002
"""Noise of a tick's motion, as a share of it, and the speed below which wheels stand [m/s]."""
ERROR_SD = np.array([0.00025, 0.00025, math.radians(0.12)])
"""Of the estimate [m, m, rad]."""
PICTURE_S = 0.06
"""Its error is another one after so long [s]."""
SURE = Integrity(State.CERTAIN, 0.02, 0.02)
UNSURE = Integrity(State.APPROXIMATE, 0.12, 0.1)
DOUBTFUL = Integrity(State.APPROXIMATE, math.inf, math.pi)
BLIND = Integrity(State.CERTAIN, 0.045, 0.09)
MOVED_S = 2.0
"""A robot is pushed, or in doubt, so long after it set out [s]."""
DOUBTS_S = (0.5, 2.5)
"""How long it is in doubt [s]."""
PUSH_M = 0.07
SCAN = Scan(0.0, np.zeros(1), np.full(1, math.inf))


@dataclass(frozen=True, eq=False)
class JourneyTrial:
    """Where to drive, and how."""

    ends: list[tuple[str, Pose2, Pose2]]
    """Kind, start and goal."""
    seed: int


def recorded(kept: Path | None, seed: int = 0) -> list[JourneyTrial]:
    """Return the trial; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        trials: list[JourneyTrial] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return trials
    rng = np.random.default_rng(SEED + seed)
    free = _space()
    ends = [(kind, *_way(free, kind, rng)) for _ in range(ROUNDS) for kind in KINDS]
    trials = [JourneyTrial(ends, SEED + seed)]
    if kept is not None:
        kept.write_bytes(pickle.dumps(trials))
    return trials


def few(trials: list[JourneyTrial]) -> list[JourneyTrial]:
    """Return all: they are few."""
    return trials


def tried(trials: list[JourneyTrial], other_numbers: int) -> dict[str, Any]:
    """Drive all journeys; return figures by name, and numbers of results.

    Args:
        other_numbers: if not 0, the seed of other journeys.
    """
    (trial,) = recorded(None, other_numbers) if other_numbers else trials
    free, rng = _space(), np.random.default_rng(trial.seed)
    drivers = [_Driver(free, kind, start, goal, rng) for kind, start, goal in trial.ends]
    for driver in drivers:
        driver.drive()
    arrived = [each for each in drivers if each.arrived and each.kind != "curve"]
    distances = [each.pose.distance_to(each.goal) for each in arrived]
    turned = [abs(math.remainder(each.pose.theta - each.goal.theta, math.tau)) for each in arrived]
    clearance = free.settings.clearance
    return {
        "journey [s]": _mean([each.stamp for each in arrived]),
        "place off [mm]": 1e3 * _mean(distances),
        "heading off [deg]": math.degrees(_mean(turned)),
        "off its way [mm]": 1e3 * float(np.mean([each.beside for each in drivers])),
        "nearer to walls [mm]": 1e3
        * float(np.mean([max(clearance - each.room, 0.0) for each in drivers])),
        "ways planned": float(np.mean([each.plans for each in drivers])),
        "not reached": sum(not each.arrived for each in drivers),
        "each": [zlib.crc32(each.pose.to_array().tobytes()) for each in drivers],
    }


def _mean(values: list[float]) -> float:
    """Return the mean; nan of none, as where no robot arrives."""
    return float(np.mean(values)) if values else math.nan


def _space() -> FreeSpace:
    return FreeSpace.of(load_field(FIELD, MAPS), RobotSpec.load().outline, NavigationSettings())


def _way(free: FreeSpace, kind: str, rng: np.random.Generator) -> tuple[Pose2, Pose2]:
    """Return two places between which there is a way; of a curve, with room at its end."""
    around = np.linspace(0.0, 2 * math.pi, 24)
    circle = np.column_stack([np.sin(around), 1 - np.cos(around)]) * CIRCLE_M
    while True:
        start, goal = _place(free, rng), _place(free, rng)
        if kind == "curve" and not free.turns(goal.apply(circle)):
            continue
        try:
            if PLANNERS["grid"].plan(free, start, goal) and PLANNERS["lattice"].plan(
                free, start, goal
            ):
                return start, goal
        except NoWayError:
            continue


def _place(free: FreeSpace, rng: np.random.Generator) -> Pose2:
    xmin, ymin, xmax, ymax = free.drive_area
    while True:
        pose = rng.uniform((xmin, ymin, -math.pi), (xmax, ymax, math.pi))
        if free.fits(pose[None]):
            return Pose2.from_array(pose)


class _Driver:
    """A robot on one journey."""

    def __init__(
        self, free: FreeSpace, kind: str, start: Pose2, goal: Pose2, rng: np.random.Generator
    ) -> None:
        self.kind, self.goal, self.pose = kind, goal, start
        self.stamp, self.plans, self.room = 0.0, 0, math.inf
        self.beside = 0.0
        """How far it is from where it shall be, at most [m]."""
        self._free, self._rng = free, rng
        self._drive = DriveSettings()
        self._twist, self._odom = Twist2(), Pose2()
        self._late = deque([Twist2()] * round(free.settings.command_lag / TICK))
        self._error, self._changes_at = np.zeros(3), 0.0
        self._doubted_until = 0.0
        self._navigator = self._new_navigator()

    def _new_navigator(self) -> Navigator:
        settings = self._free.settings
        limits = Limits.of(self._drive, settings, RIM, TRACK)
        curve = ClosedCurve("circle", CIRCLE_M, start=self.goal) if self.kind == "curve" else None
        pursues = self.kind == "pursuit"
        controller: PathController = RegulatedPurePursuit() if pursues else Tracker()
        return Navigator(
            () if curve else (Goal(*self.goal.to_array().tolist()),),
            settings,
            limits.along_curve(CURVE_SPEED, self._drive) if curve else limits,
            look=lambda views, odom, places, dares: Move((turn(odom, odom.theta + 1.0),), "told"),
            curve=curve,
            planner=self._planner,
            controller=controller,
        )

    @property
    def _planner(self) -> Planner:
        return PLANNERS[self.kind if self.kind in PLANNERS else "grid"].plan

    @property
    def arrived(self) -> bool:
        """Whether it is there; a closed curve has no end."""
        state = self._navigator.status.state
        return state == "driving" if self.kind == "curve" else state == "arrived"

    def drive(self) -> None:
        """Drive until the journey is over."""
        longest = CURVE_S if self.kind == "curve" else LONGEST_S
        due = 0.0
        plan: Plan | NoWayError = None
        while self._navigator.status.active and self.stamp < longest:
            self.stamp += TICK
            sensed = self._sensed()
            job = self._navigator.job(lambda: self._free, sensed)
            if job is not None:
                self.plans += 1
                due = self.stamp + PLANNED_S
                try:
                    plan = job()
                except NoWayError as error:
                    plan = error
            elif due and self.stamp >= due:
                due = 0.0
                self._navigator.take(plan)
            self._move(self._navigator.step(sensed))

    def _sensed(self) -> Sensed:
        if self.stamp >= self._changes_at:
            self._error = self._rng.normal(0.0, ERROR_SD)
            self._changes_at = self.stamp + PICTURE_S
        believed = self.pose @ Pose2.from_array(self._error)
        view = Glimpse(self._odom, SCAN)
        return Sensed(self.stamp, believed, self._twist, self._known(), self._odom, view)

    def _known(self) -> Integrity:
        """Return how well it knows its place now."""
        if self.kind == "in doubt" and self.stamp > MOVED_S and not self._doubted_until:
            self._doubted_until = MOVED_S + float(self._rng.choice(DOUBTS_S))
        if self.stamp < self._doubted_until:
            return DOUBTFUL
        if self.kind == "blind":
            return BLIND
        return UNSURE if self.kind == "unsure" else SURE

    def _move(self, command: Twist2) -> None:
        """Turn the wheels as they were told some time ago, as fast as they can."""
        self._late.append(command)
        command, before, drive = self._late.popleft(), self._twist, self._drive
        side = command.omega * TRACK / 2
        left, right = command.v - side, command.v + side
        left, right = (0.0 if abs(each) < SLOWEST else each for each in (left, right))
        v, omega = (left + right) / 2, (right - left) / TRACK
        gain = drive.max_acceleration if abs(v) > abs(before.v) else drive.max_deceleration
        v = before.v + min(max(v - before.v, -gain * TICK), gain * TICK)
        most = drive.max_angular_acceleration * TICK
        omega = before.omega + min(max(omega - before.omega, -most), most)
        self._twist = Twist2(v, omega)
        step = self._twist.integrate(TICK)
        along, turned = 1 + SLIP * self._rng.normal(size=2)
        self._odom @= step
        self.pose @= Pose2(along * step.x, along * step.y, turned * step.theta)
        if self.kind == "pushed" and self.stamp - TICK < MOVED_S <= self.stamp:
            self.pose @= Pose2(0.0, PUSH_M * float(self._rng.choice((-1.0, 1.0))), 0.0)
        target = self._navigator.status.target
        if target is not None and self.kind != "pushed":
            self.beside = max(self.beside, self.pose.distance_to(target))
        self.room = min(self.room, float(self._free.room(self.pose.to_array()[None])[0]))
