"""A simulated robot that drives known motions by its odometry, again and again."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from app.lab.model_fits.motion.run import MotionRun
from app.lab.model_fits.trials.motions import MOTIONS, Leg
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

REST = 0.3
"""Standing time before a motion and after each of its legs [s]: motors lag."""

CREEP = 0.03
"""The end of a leg is reached at this part of its speed."""

STARTING = 0.5
"""Time to gain a leg's speed [s]: both axes then stay within their limits, and arcs are arcs."""

NEARING = 3.0
"""Speed by the way that is left [1/s]: so slow before the end that motors that lag keep up."""

WORLDS = ("sim", "kinematic")


@dataclass(frozen=True, eq=False)
class TrialRobot:
    """A robot, what it believes of itself, and how it drives."""

    spec: RobotSpec
    """The description, by which odometry reckons."""
    true: RobotSpec
    """Its true dimensions."""
    imperfections: Imperfections = field(default_factory=Imperfections)
    """Slip and counting of its encoders."""
    drive: DriveSettings = field(default_factory=DriveSettings)
    physics: BulletSettings = field(default_factory=BulletSettings)
    world: str = "sim"
    """"sim", with forces, or "kinematic"."""
    seed: int = 0
    speed: float = 0.2
    """[m/s]"""
    turning: float = 1.0
    """[rad/s]"""

    def __post_init__(self) -> None:
        if self.world not in WORLDS:
            raise ValueError(f"world is {self.world!r}; valid are {', '.join(WORLDS)}")


@dataclass(frozen=True, eq=False)
class MotionTrial:
    """One motion, driven once more."""

    robot: TrialRobot
    motion: str
    """A name of ``MOTIONS``."""
    repeat: int

    def __post_init__(self) -> None:
        if self.motion not in MOTIONS:
            raise ValueError(f"motion is {self.motion!r}; valid are {', '.join(MOTIONS)}")


def trials(robot: TrialRobot, repeats: int) -> list[MotionTrial]:
    """All motions, each so many times; those driven first have each of them once."""
    return [MotionTrial(robot, name, repeat) for repeat in range(repeats) for name in MOTIONS]


def run_motion(trial: MotionTrial) -> MotionRun:
    """Drive one motion; slip and where the encoders stand are drawn anew by seed and repeat.

    Odometry and truth begin at the same pose (0, 0, 0).

    Raises:
        BulletMissingError: the physics engine is not installed.
    """
    robot = trial.robot
    world = _world(robot)
    name = zlib.crc32(trial.motion.encode())
    rng = np.random.default_rng([robot.seed, name, trial.repeat])
    try:
        return _Trial(robot, world, rng).drive(trial.motion)
    finally:
        world.close()


def _world(robot: TrialRobot) -> World:
    if robot.world == "sim":
        return BulletWorld(robot.true, Pose2(), settings=robot.physics)
    return KinematicWorld(robot.true, Pose2(), step_time=PERIOD)


class _Trial:
    """The loop around a world: encoders, odometry, controller, wheels."""

    def __init__(self, robot: TrialRobot, world: World, rng: np.random.Generator) -> None:
        self._robot = robot
        self._world = world
        self._steps = round(PERIOD / world.step_time)
        self._kinematics = DifferentialDrive(robot.spec)
        self._controller = DriveController(self._kinematics, robot.drive)
        self._encoders = Encoders(robot.spec, robot.imperfections, rng)
        self._positions, _ = self._encoders.read(world.positions, 0.0)
        self._stamps = [0.0]
        self._odometry = [Pose2()]
        self._truth = [world.pose]

    def drive(self, motion: str) -> MotionRun:
        """The whole motion with its rests."""
        self._rest()
        for leg in MOTIONS[motion]:
            for twist in self._along(leg):
                self._tick(twist)
            self._rest()
        return MotionRun(
            motion,
            np.array(self._stamps),
            np.array([pose.to_array() for pose in self._odometry]),
            np.array([pose.to_array() for pose in self._truth]),
        )

    def _along(self, leg: Leg) -> Iterator[Twist2]:
        """What to command until odometry says that a leg is done."""
        fastest = min(
            self._robot.speed / max(abs(leg.distance), 1e-9),
            self._robot.turning / max(abs(leg.turn), 1e-9),
        )
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
        now = self._stamps[-1]
        self._controller.command(wanted, now)
        wheels = self._kinematics.wheels(self._controller.update(now))
        for _ in range(self._steps):
            self._world.step(wheels)
        stamp = len(self._stamps) * PERIOD
        positions, _ = self._encoders.read(self._world.positions, stamp)
        moved = self._kinematics.moved(positions - self._positions)
        self._positions = positions
        self._stamps.append(stamp)
        self._odometry.append(self._odometry[-1] @ moved)
        self._truth.append(self._world.pose)
