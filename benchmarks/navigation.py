"""Benchmark of navigation: planning on a grid of 5 mm, and one tick of control."""

from __future__ import annotations

import math
import time

import numpy as np

from app.settings.config import MAPS
from benchmarks.result import Result
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2
from robot.localization.estimate import Integrity, State
from robot.navigation.free_space import FreeSpace
from robot.navigation.goal import Goal
from robot.navigation.lattice import plan_in_headings
from robot.navigation.lookout import Move
from robot.navigation.navigator import Navigator
from robot.navigation.planners import find_way
from robot.navigation.planning import NoWayError, Planner, plan
from robot.navigation.sensed import Sensed
from robot.navigation.settings import NavigationSettings
from robot.navigation.timed_way import Limits

FIELD = "town"
GOALS = 80
LIMITS = Limits(0.2, 0.48, 0.8, 1.8, 3.2, 0.33, 0.056)
TICK_S = 0.02
SURE = Integrity(State.CERTAIN, 0.01, 0.02)


def measure() -> Result:
    """Plan between random places of a town where the robot fits, and drive one way.

    Times are the processor's, so that work beside it does not count.
    """
    free = FreeSpace.of(load_field(FIELD, MAPS), RobotSpec.load().outline, NavigationSettings())
    pairs = _pairs(free, np.random.default_rng(0))
    more: dict[str, float] = {}
    planners: dict[str, Planner] = {"A*": plan, "grid": find_way, "lattice": plan_in_headings}
    for name, planner in planners.items():
        way_times, refusal_times = _times(planner, free, pairs)
        more |= _figures(f"{name}, a way", way_times) | _figures(f"{name}, no way", refusal_times)
    ticks = _ticks(free, *next(pair for pair in pairs if _has_way(free, *pair)))
    more |= _figures("one tick of control", ticks)
    return Result("ms, A* on town, the slowest way", more["A*, a way, slowest [ms]"], more=more)


def _pairs(free: FreeSpace, rng: np.random.Generator) -> list[tuple[Pose2, Pose2]]:
    """Return places where robots usually drive, two and two; there is a way between a third."""
    xmin, ymin, xmax, ymax = free.drive_area
    places: list[Pose2] = []
    while len(places) < 2 * GOALS:
        pose = rng.uniform((xmin, ymin, -math.pi), (xmax, ymax, math.pi))
        if free.fits(pose[None]):
            places.append(Pose2.from_array(pose))
    return list(zip(places[::2], places[1::2], strict=True))


def _times(
    planner: Planner, free: FreeSpace, pairs: list[tuple[Pose2, Pose2]]
) -> tuple[list[float], list[float]]:
    """Return the times of those plans that found a way, and of the others [s]."""
    way_times: list[float] = []
    refusal_times: list[float] = []
    # Compiled code is loaded, and the space's costs are worked out, once.
    planner(free, *next(pair for pair in pairs if _has_way(free, *pair)))
    for start, goal in pairs:
        began = time.thread_time()
        try:
            planner(free, start, goal)
            way_times.append(time.thread_time() - began)
        except NoWayError:
            refusal_times.append(time.thread_time() - began)
    return way_times, refusal_times


def _has_way(free: FreeSpace, start: Pose2, goal: Pose2) -> bool:
    try:
        return bool(plan(free, start, goal))
    except NoWayError:
        return False


def _ticks(free: FreeSpace, start: Pose2, goal: Pose2) -> list[float]:
    """Return the times of the ticks of an ideal robot on one way [s]."""
    navigator = Navigator(
        (Goal(goal.x, goal.y, goal.theta),),
        free.settings,
        LIMITS,
        look=lambda *_: Move((), "it knows"),
    )
    pose, twist, stamp = start, Twist2(), 0.0
    times: list[float] = []
    while navigator.status.active:
        stamp += TICK_S
        sensed = Sensed(stamp, pose, twist, SURE, pose)
        began = time.thread_time()
        job = navigator.job(lambda: free, sensed)
        spent = time.thread_time() - began
        plan_found = None if job is None else job()
        began = time.thread_time()
        if job is not None:
            navigator.take(plan_found)
        twist = navigator.step(sensed)
        times.append(spent + time.thread_time() - began)
        pose = pose @ twist.integrate(TICK_S)
    return times


def _figures(name: str, times: list[float]) -> dict[str, float]:
    if not times:
        return {}
    median, slowest = float(np.median(times)), max(times)
    return {f"{name}, median [ms]": 1000 * median, f"{name}, slowest [ms]": 1000 * slowest}
