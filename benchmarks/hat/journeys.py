"""Benchmark of journeys by the real robot's driver: to random goals, on the emulated board.

Physics turns the wheels, and a camera looks at the floor, as behind `brickpose emulate-hat`; but
the time of all of them is stepped, so that a drive is the same however busy the computer is.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

import numpy as np
from tqdm import tqdm

from app.engine.build import Streams, build_program
from app.engine.engine import Engine
from app.features.lab.evaluation.drives import silent
from app.features.navigation.messages import GoalMessage, NavigateCommand
from app.messages.driving_commands import StopCommand
from app.settings.config import MAPS, Config
from benchmarks.hat.bricks import Bricks
from benchmarks.result import Result
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.interface import Frame
from robot.navigation.free_space import FreeSpace
from robot.navigation.navigation_status import NavigationStatus
from robot.navigation.planners import find_way
from robot.navigation.planning import NoWayError
from robot.navigation.settings import NavigationSettings
from sim.engines import physics_world
from sim.floor_camera import FloorCamera
from sim.hat_emulator.picture_server import Shot
from sim.hat_emulator.surroundings import RobotOnField
from sim.imperfections import draw

SEEDS, GOALS, FIELDS = range(12), 5, ("square", "town")
STREAM = 12
"""Number of the random stream, beside the seed, that goals are drawn from."""
STANDS_S = 1.0
"""The robot stands so long before its first goal, and before the truth is looked at [s]."""
LONGEST_S = 120.0
"""A journey that takes longer has not arrived [s]."""
RENEWAL = NavigateCommand(type="navigate")


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
    """Send twelve robots on each of two fields to five goals, one after the other."""
    robots = [(name, seed) for name in FIELDS for seed in SEEDS]
    each = (drive(name, seed) for name, seed in tqdm(robots, unit="robot", disable=None))
    journeys = [journey for robot in each for journey in robot]
    arrived = [journey for journey in journeys if journey.state == "arrived"]
    result = Result(unit=f"of {len(journeys)} goals reached", brickpose=len(arrived))
    if not arrived:
        return result
    errors = 1e3 * np.array([journey.error for journey in arrived])
    turns = np.degrees([journey.turn for journey in arrived])
    figures = {
        "place, median [mm]": np.median(errors),
        "place, worst [mm]": errors.max(),
        "heading, median [degree]": np.median(turns),
        "heading, worst [degree]": turns.max(),
    }
    return replace(result, more={name: float(value) for name, value in figures.items()})


def drive(name: str, seed: int, goals: int = GOALS) -> list[HatJourney]:
    """Send one robot on a field to random goals, one after the other."""
    rng = np.random.default_rng([seed, STREAM])
    with robot_on_board(Config(map=name, seed=seed)) as trial:
        trial.stand()
        return [trial.journey(rng) for _ in range(goals)]


@dataclass
class BoardCamera:
    """A ``Camera`` of the robot that stands on the floor; its clock is the board's."""

    view: FloorCamera
    bricks: Bricks
    name: str = "the simulated camera"
    problem: str | None = None
    _shots: deque[Shot] = field(default_factory=deque)

    def take(self, shot: Shot) -> None:
        """Hand this picture out when it is due."""
        self._shots.append(shot)

    def newest(self) -> Frame | None:
        """Return the newest picture that is due; None if it was handed out before."""
        shot = None
        while self._shots and self._shots[0].due <= self.bricks.now:
            shot = self._shots.popleft()
        return None if shot is None else Frame(shot.stamp, self.view.picture(shot.pose, shot.twist))

    def close(self) -> None:
        """Do nothing: nothing is held."""


@dataclass
class BoardTrial:
    """An engine with the real robot's driver, and where its robot truly is."""

    engine: Engine
    around: RobotOnField
    free: FreeSpace

    def stand(self) -> None:
        """Let the board start, and time pass."""
        while not self.engine.step().connected:
            pass
        self._run(STANDS_S)

    def journey(self, rng: np.random.Generator) -> HatJourney:
        """Drive to a random goal."""
        goal = self._drawn(rng)
        message = GoalMessage(x=goal.x, y=goal.y, theta=goal.theta)
        self.engine.commands.put(NavigateCommand(type="navigate", poses=[message]))
        snapshot = self.engine.step()
        end = snapshot.stamp + LONGEST_S
        while snapshot.stamp < end and self._status.active:
            self.engine.commands.put(RENEWAL)
            snapshot = self.engine.step()
        status = self._status
        if status.active:
            self.engine.commands.put(StopCommand(type="stop"))
        self._run(STANDS_S)
        truth = self.around.truth
        return HatJourney(
            status.state, status.reason, truth.distance_to(goal), abs(truth.turn_to(goal))
        )

    @property
    def _status(self) -> NavigationStatus:
        latest = self.engine.latest.get()
        assert latest is not None
        status: NavigationStatus = latest.added["navigation"]
        return status

    def _drawn(self, rng: np.random.Generator) -> Pose2:
        """Return a random pose where the robot fits, and to which a way leads."""
        left, bottom, right, top = self.free.drive_area
        while True:
            x, y = rng.uniform(left, right), rng.uniform(bottom, top)
            goal = Pose2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))
            try:
                find_way(self.free, self.around.truth, goal)
            except NoWayError:
                continue
            return goal

    def _run(self, seconds: float) -> None:
        end = self.engine.step().stamp + seconds
        while self.engine.step().stamp < end:
            pass


@contextmanager
def robot_on_board(config: Config) -> Iterator[BoardTrial]:
    """Build the robot that ``emulate-hat`` shows, and a program with the driver of a real one."""
    described, floor = RobotSpec.load(), load_field(config.map, MAPS)
    rng = Streams.of(config.seed).robot
    true = draw(described, config.sim.imperfections, rng)
    world = physics_world(config.sim.engine, true, floor.start, config.sim.physics)
    around = RobotOnField(world, true)
    try:
        bricks = Bricks(plants=around.plants)
        camera = BoardCamera(
            FloorCamera(true.floor_view, floor.floor, config.sim.camera, rng), bricks
        )
        ahead = bricks.now - around.plants.now
        around.has_camera(
            config.sim.camera, true.lens.readout, lambda stamp: stamp + ahead, camera.take
        )
        program = build_program(config, robot=bricks.robot(camera), field=floor)
        try:
            settings = config.group("navigation", NavigationSettings())
            free = FreeSpace.of(floor, described.outline, settings)
            yield BoardTrial(silent(program.engine), around, free)
        finally:
            program.robot.close()
    finally:
        around.close()
