"""A simulated robot that repeatedly drives known motions by its odometry."""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from app.engine.build import connect
from app.engine.driving import Driving
from app.engine.follower import Follower
from app.features.lab.model_fits.motions import MotionRun
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController, DriveSettings
from robot.driving.odometry import OdometryState
from robot.geometry import Array, Pose2, Twist2
from robot.interface import Reading
from sim.encoders import Encoders
from sim.engines import physics_world
from sim.imperfections import Imperfections
from sim.physics import PhysicsSettings
from sim.simulated import PERIOD
from sim.world import KinematicWorld, World

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
    physics: PhysicsSettings = field(default_factory=PhysicsSettings)
    has_forces: bool = True
    """Whether an engine of physics moves it; else its wheels roll as if on rails."""
    engine: str = "auto"
    """The engine of the physics."""
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
    if robot.has_forces:
        world = physics_world(robot.engine, robot.true, Pose2(), robot.physics)
    else:
        world = KinematicWorld(robot.true, Pose2(), step_time=PERIOD)
    drive = _MotionDrive(robot, MOTIONS[trial.motion])
    engine = connect(Config(), _Wheels(robot, world, rng), Follower(), driving=drive)
    stamps, odometry, truth = [], [], []
    try:
        while not drive.over:
            snapshot = engine.step()
            assert snapshot.truth is not None  # it is simulated
            stamps.append(snapshot.stamp)
            odometry.append(snapshot.odom_from_robot.to_array())
            truth.append(snapshot.truth.to_array())
    finally:
        world.close()
    return MotionRun(trial.motion, np.array(stamps), np.array(odometry), np.array(truth))


class _Wheels:
    """A simulated robot without a camera: time passes whenever the wheels are commanded."""

    name = "Robot of a trial"

    def __init__(self, robot: TrialRobot, world: World, rng: np.random.Generator) -> None:
        self.spec = robot.spec
        self._world = world
        self._encoders = Encoders(robot.spec, robot.imperfections, rng)
        self._tick = 0

    def read(self) -> Reading:
        """Return what the encoders measure."""
        stamp = self._tick * PERIOD
        positions, velocities = self._encoders.read(self._world.positions, stamp)
        return Reading(stamp, positions, velocities, truth=self._world.pose)

    def write(self, velocities: Array) -> Array:
        """Advance by one period at joint velocities (j,) [rad/s]."""
        self._world.step(velocities, round(PERIOD / self._world.step_time))
        self._tick += 1
        return velocities

    def close(self) -> None:
        """Release the world."""
        self._world.close()


class _MotionDrive(Driving):
    """Drives the legs of a motion and rests after each of them, as odometry says."""

    def __init__(self, robot: TrialRobot, legs: tuple[Leg, ...]) -> None:
        controller = DriveController(DifferentialDrive(robot.spec), robot.drive)
        super().__init__(controller, robot.drive.cmd_vel_timeout)
        self.over = False
        """Whether the last rest has ended."""
        self._twists = self._along(legs)
        self._pose = self._moved = Pose2()

    def update(self, odometry: OdometryState) -> Twist2:
        """Return the twist to apply where the robot is now by odometry."""
        pose = odometry.odom_from_robot
        self._moved, self._pose = self._pose.inverse() @ pose, pose
        twist = next(self._twists, None)
        if twist is None:
            self.over = True
        else:
            self.drive(twist, odometry.stamp)
        return super().update(odometry)

    def _along(self, legs: tuple[Leg, ...]) -> Iterator[Twist2]:
        """Yield a command for each tick of the motion."""
        rest = [Twist2()] * round(REST / PERIOD)
        yield from rest
        for leg in legs:
            yield from self._along_leg(leg)
            yield from rest

    def _along_leg(self, leg: Leg) -> Iterator[Twist2]:
        """Yield the commands of a leg, until odometry reaches its end."""
        fastest = min(SPEED / max(abs(leg.distance), 1e-9), TURNING / max(abs(leg.turn), 1e-9))
        left, rate = 1.0, 0.0
        while left > 0:
            rate += fastest * PERIOD / STARTING
            rate = max(min(rate, fastest, NEARING * left), CREEP * fastest)
            yield leg.twist(rate)
            left -= leg.share(self._moved)
