"""Benchmark of journeys by the real robot's driver: to random goals, over the serial line.

`brickpose emulate-hat` turns the wheels of a simulated robot and shows it the floor, and
`brickpose run --robot buildhat` drives it to one goal after the other. This process draws the
goals, and asks the emulator for the truth when the robot says that it has arrived.
"""

from __future__ import annotations

import json
import math
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from websockets.sync.connection import Connection

from app.engine.robots import robot_spec
from app.settings.config import MAPS, Config
from benchmarks.hat.emulated_hat import EmulatedHat
from benchmarks.hat.programs import robot_in_bricks
from benchmarks.programs import START_S, Telemetry, connected, estimated, telemetry, until
from benchmarks.result import Result
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.planners import find_way
from robot.navigation.planning import NoWayError
from robot.navigation.settings import NavigationSettings

SEEDS, GOALS = range(12), 5
STREAM = 12
"""Number of the random stream, beside the seed, that goals are drawn from."""
STANDS_S = 1.0
"""The robot stands so long before its first goal, and before the truth is asked [s]."""
LONGEST_S = 120.0
"""A journey that takes longer has not arrived [s]."""


@dataclass(frozen=True)
class HatJourney:
    """What became of one journey."""

    state: str
    reason: str
    error: float
    """Of the true place from the goal, at the end [m]."""
    turn: float
    """Of the true heading [rad]."""


def measure() -> Result:
    """Send twelve robots to five goals each, one robot after the other."""
    journeys = [each for seed in SEEDS for each in drive(seed)]
    arrived = [each for each in journeys if each.state == "arrived"]
    result = Result(unit=f"of {len(journeys)} goals reached", brickpose=len(arrived))
    if not arrived:
        return result
    errors = 1e3 * np.array([each.error for each in arrived])
    turns = np.degrees([each.turn for each in arrived])
    figures = {
        "place, median [mm]": np.median(errors),
        "place, worst [mm]": errors.max(),
        "heading, median [degree]": np.median(turns),
        "heading, worst [degree]": turns.max(),
    }
    return replace(result, more={name: float(value) for name, value in figures.items()})


def drive(seed: int, goals: int = GOALS) -> list[HatJourney]:
    """Send one robot on the square to random goals, one after the other."""
    config = Config()
    free = FreeSpace.of(
        load_field(config.map, MAPS), robot_spec(config).outline, NavigationSettings()
    )
    rng = np.random.default_rng([seed, STREAM])
    with (
        tempfile.TemporaryDirectory() as folder,
        robot_in_bricks(Path(folder), seed) as (hat, server),
        server.live() as socket,
    ):
        until(socket, connected, START_S)
        until(socket, estimated, START_S)
        _wait(socket, STANDS_S)
        return [_journey(socket, hat, free, rng) for _ in range(goals)]


def _journey(
    socket: Connection, hat: EmulatedHat, free: FreeSpace, rng: np.random.Generator
) -> HatJourney:
    goal = drawn_goal(free, Pose2(*hat.pose()[1]), rng)
    asked = {"x": goal.x, "y": goal.y, "theta": goal.theta}
    socket.send(json.dumps({"type": "navigate", "poses": [asked]}))
    until(socket, _active, START_S)
    try:
        until(socket, lambda message: not _active(message), LONGEST_S)
    except TimeoutError:
        socket.send(json.dumps({"type": "cancel"}))
    shown = _wait(socket, STANDS_S)["navigation"]
    truth = Pose2(*hat.pose()[1])
    return HatJourney(
        shown["state"], shown["reason"] or "", truth.distance_to(goal), abs(truth.turn_to(goal))
    )


def _active(message: Telemetry) -> bool:
    return (message["navigation"] or {}).get("state") in ("planning", "driving", "waiting")


def drawn_goal(free: FreeSpace, start: Pose2, rng: np.random.Generator) -> Pose2:
    """Return a random pose where the robot fits, and to which a way leads."""
    left, bottom, right, top = free.drive_area
    while True:
        x, y = rng.uniform(left, right), rng.uniform(bottom, top)
        goal = Pose2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
        try:
            find_way(free, start, goal)
        except NoWayError:
            continue
        return goal


def _wait(socket: Connection, seconds: float) -> Telemetry:
    begin = telemetry(socket)["stamp"]
    return until(socket, lambda message: message["stamp"] >= begin + seconds)
