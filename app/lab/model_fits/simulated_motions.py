"""A simulated robot that repeatedly drives known motions by its odometry."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from app.lab.model_fits.runs import MotionRun
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController, DriveSettings
from robot.geometry import Pose2, Twist2
from sim.bullet import BulletSettings, BulletWorld
from sim.encoders import Encoders
from sim.imperfections import Imperfections
from sim.kinematic import KinematicWorld
from sim.simulated import PERIOD
from sim.world import World

SPEED, TURNING = 0.2, 1.0
"""Highest speed and turn rate of a leg [m/s], [rad/s]."""

REST = 0.3
"""Standing time before a motion and after each of its legs [s]: motors lag."""

CREEP = 0.03
"""The robot reaches the end of a leg at this share of its speed."""

STARTING = 0.5
"""Time to reach a leg's speed [s]: then both axes stay within their limits, and arcs stay arcs."""

NEARING = 3.0
"""Speed per remaining distance [1/s]: slow enough before the end for motors that lag."""

ARC_RADIUS = 0.19
"""Radius of arcs, that of the circles in the paper's figure-eight [m]."""

SIDE = 1.0
"""Length of straights and of the sides of squares [m]."""

QUARTER = math.pi / 2


@dataclass(frozen=True, slots=True)
class Leg:
    """A stretch along one curve, which ends when odometry reaches its end."""

    distance: float
    """Distance to drive [m]; negative is backwards."""
    turn: float
    """Angle to turn [rad]; positive is to the left."""

    def share(self, step: Pose2) -> float:
        """Return the share of the leg that a small step covers."""
        return step.theta / self.turn if self.turn else step.x / self.distance

    def twist(self, rate: float) -> Twist2:
        """Return the twist along the leg at a rate [legs/s]."""
        return Twist2(self.distance * rate, self.turn * rate)


MOTIONS: dict[str, tuple[Leg, ...]] = {
    "straight_forward": (Leg(SIDE, 0.0),),
    "straight_back": (Leg(-SIDE, 0.0),),
    "turn_left_90": (Leg(0.0, QUARTER),),
    "turn_right_90": (Leg(0.0, -QUARTER),),
    "turn_left_360": (Leg(0.0, 4 * QUARTER),),
    "turn_right_360": (Leg(0.0, -4 * QUARTER),),
    "arc_left_270": (Leg(ARC_RADIUS * 3 * QUARTER, 3 * QUARTER),),
    "arc_right_270": (Leg(ARC_RADIUS * 3 * QUARTER, -3 * QUARTER),),
    "square_ccw": (Leg(SIDE, 0.0), Leg(0.0, QUARTER)) * 4,
    "square_cw": (Leg(SIDE, 0.0), Leg(0.0, -QUARTER)) * 4,
}


@dataclass(frozen=True, eq=False)
class TrialRobot:
    """A robot, its described and its true dimensions, and its world."""

    spec: RobotSpec
    """The description that odometry uses."""
    true: RobotSpec
    """The true dimensions."""
    imperfections: Imperfections = field(default_factory=Imperfections)
    """Slip, and the steps of the encoders."""
    drive: DriveSettings = field(default_factory=DriveSettings)
    physics: BulletSettings = field(default_factory=BulletSettings)
    world: Literal["sim", "kinematic"] = "sim"
    """With physics, or with kinematics only."""
    seed: int = 0


@dataclass(frozen=True, eq=False)
class MotionTrial:
    """One repetition of a motion."""

    robot: TrialRobot
    motion: str
    """A name of ``MOTIONS``."""
    repeat: int


def trials(robot: TrialRobot, repeats: int) -> list[MotionTrial]:
    """Return all motions, each repeated; every motion comes once before any comes again."""
    return [MotionTrial(robot, name, repeat) for repeat in range(repeats) for name in MOTIONS]


def run_motion(trial: MotionTrial) -> MotionRun:
    """Drive one motion; seed and repeat determine slip and the encoders' start positions.

    Odometry and truth both begin at the pose (0, 0, 0).

    Raises:
        PackageError: the physics engine is not installed.
    """
    robot, name = trial.robot, zlib.crc32(trial.motion.encode())
    rng = np.random.default_rng([robot.seed, name, trial.repeat])
    world: World
    if robot.world == "sim":
        world = BulletWorld(robot.true, Pose2(), settings=robot.physics)
    else:
        world = KinematicWorld(robot.true, Pose2(), step_time=PERIOD)
    try:
        return _Drive(robot, world, rng).along(trial.motion)
    finally:
        world.close()


class _Drive:
    """The loop around a world: encoders, odometry, controller, wheels."""

    def __init__(self, robot: TrialRobot, world: World, rng: np.random.Generator) -> None:
        self._world = world
        self._steps = round(PERIOD / world.step_time)
        self._kinematics = DifferentialDrive(robot.spec)
        self._controller = DriveController(self._kinematics, robot.drive)
        self._encoders = Encoders(robot.spec, robot.imperfections, rng)
        self._positions, _ = self._encoders.read(world.positions, 0.0)
        self._odometry = [Pose2()]
        self._truth = [world.pose]

    def along(self, motion: str) -> MotionRun:
        """Drive the whole motion with its rests."""
        self._rest()
        for leg in MOTIONS[motion]:
            for twist in self._twists(leg):
                self._tick(twist)
            self._rest()
        return MotionRun(
            motion,
            PERIOD * np.arange(len(self._truth), dtype=np.float64),
            np.array([pose.to_array() for pose in self._odometry]),
            np.array([pose.to_array() for pose in self._truth]),
        )

    def _twists(self, leg: Leg) -> Iterator[Twist2]:
        """Yield the commands of a leg, until odometry reaches its end."""
        fastest = min(SPEED / max(abs(leg.distance), 1e-9), TURNING / max(abs(leg.turn), 1e-9))
        left, rate = 1.0, 0.0
        while left > 0:
            rate += fastest * PERIOD / STARTING
            rate = max(min(rate, fastest, NEARING * left), CREEP * fastest)
            yield leg.twist(rate)
            left -= leg.share(self._odometry[-2].inverse() @ self._odometry[-1])

    def _rest(self) -> None:
        for _ in range(round(REST / PERIOD)):
            self._tick(Twist2())

    def _tick(self, wanted: Twist2) -> None:
        stamp = (len(self._truth) - 1) * PERIOD
        self._controller.command(wanted, stamp)
        wheels = self._kinematics.wheels(self._controller.update(stamp))
        for _ in range(self._steps):
            self._world.step(wheels)
        positions, _ = self._encoders.read(self._world.positions, stamp + PERIOD)
        moved = self._kinematics.moved(positions - self._positions)
        self._positions = positions
        self._odometry.append(self._odometry[-1] @ moved)
        self._truth.append(self._world.pose)
