"""Benchmark of the physics engines: what a simulated second costs, and how far they agree."""

from __future__ import annotations

import math
import time

import numpy as np

from benchmarks.result import Result
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Pose2, Twist2
from sim.engines import choose_engine, physics_world
from sim.imperfections import Imperfections, draw
from sim.simulated import PERIOD

SECONDS = 20.0
ROBOTS = 12
RUNS = 3


def measure() -> Result:
    """Drive the same commands in both engines: two circles, as a figure-eight; and waves.

    The cost is processor time of this thread, the least of some runs, with a look at the robot
    every tick. Robots differ as simulated ones do; their tyres grip, and nothing slips.
    """
    apart = [_apart(_robot(seed)) for seed in range(ROBOTS)]
    costs = {engine: min(_cost(engine) for _ in range(RUNS)) for engine in ("mujoco", "bullet")}
    return Result(
        unit="ms of processor time a simulated second",
        brickpose=costs["mujoco"],
        peer={"pybullet": costs["bullet"]},
        more={
            f"mm apart after {SECONDS:g} s, mean of {ROBOTS} robots": 1e3 * float(np.mean(apart)),
            "mm apart, largest": 1e3 * float(np.max(apart)),
        },
    )


def _robot(seed: int) -> RobotSpec:
    return draw(RobotSpec.load(), Imperfections(), np.random.default_rng(seed))


def _commands(waves: bool) -> list[Twist2]:
    ticks = range(round(SECONDS / PERIOD))
    if waves:
        return [
            Twist2(0.1 + 0.05 * math.sin(tick / 50), 0.8 * math.sin(tick / 38)) for tick in ticks
        ]
    return [Twist2(0.15, 0.79 if tick * PERIOD % 15.9 < 7.95 else -0.79) for tick in ticks]


def _apart(true: RobotSpec) -> float:
    """Return how far a robot's ends are apart in the two engines, the larger of two drives [m]."""
    return max(
        _end("bullet", true, commands).distance_to(_end("mujoco", true, commands))
        for commands in (_commands(waves=False), _commands(waves=True))
    )


def _end(engine: str, true: RobotSpec, commands: list[Twist2]) -> Pose2:
    drive = DifferentialDrive(RobotSpec.load())
    world = physics_world(engine, true)
    steps = round(PERIOD / world.step_time)
    for twist in commands:
        world.step(drive.wheels(twist), steps)
    pose = world.pose
    world.close()
    return pose


def _cost(engine: str) -> float:
    """Return the processor time of a simulated second [ms]."""
    choose_engine(engine)
    spec = RobotSpec.load()
    drive = DifferentialDrive(spec)
    world = physics_world(engine, spec)
    steps = round(PERIOD / world.step_time)
    wheels = [drive.wheels(twist) for twist in _commands(waves=False)]
    begin = time.thread_time()
    for velocities in wheels:
        world.step(velocities, steps)
        _ = world.pose, world.twist, world.positions
    took = time.thread_time() - begin
    world.close()
    return 1e3 * took / SECONDS
