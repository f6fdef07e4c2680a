"""Record drives of the simulated robot, so that many filters can follow the same drive."""

from __future__ import annotations

import logging
import math
from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from app.engine.build import Streams, build_program
from app.engine.engine import Engine
from app.engine.localization import Localization
from app.engine.problems import Problems
from app.engine.robots import build_robot, resolve_robot, robot_kind, robot_spec
from app.engine.snapshot import Snapshot
from app.features.lab.replay_robot import ReplayRobot
from app.messages.commands import PauseCommand
from app.messages.driving_commands import DriveCommand, FigureEightCommand, StopCommand
from app.settings.config import AUTO, MAPS, Config
from app.settings.groups import StartPoseSettings
from robot.description.spec import RobotSpec
from robot.driving.figure_eight import FigureEight
from robot.errors import BrickPoseError
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Pose2, Twist2, interpolate
from robot.interface import Frame, Reading, RepositionableRobot, Robot
from robot.localization.models.entry_field import EntryField
from robot.picture_odometry.aided_odometry import PictureAidedOdometry
from robot.scan import Scan
from robot.scanning.line_scanner import LineScan, LineScanner, LineScannerSettings
from sim.simulated import no_wait

NO_PICTURE = np.zeros((1, 1), np.uint8)
"""Replaces a picture that was already searched for tape, and that nothing else looks at."""


class EvaluationError(BrickPoseError, ValueError):
    """The requested evaluation is impossible; the message says why and what is possible."""


@dataclass(frozen=True, slots=True)
class Tick:
    """One reading of the robot, and what was seen in its picture.

    The picture itself is only kept for an odometry that looks at it.
    """

    reading: Reading
    odometry: Pose2
    """In the odom frame."""
    line_scan: LineScan | None = None
    """The line scan of the reading's picture."""
    odometry_at_scan: Pose2 | None = None
    """In the odom frame, at the scan's stamp."""

    @property
    def stamp(self) -> float:
        """The stamp of the reading [s]."""
        return self.reading.stamp

    @property
    def truth(self) -> Pose2:
        """The true pose in the map."""
        assert self.reading.truth is not None  # a simulator knows it
        return self.reading.truth

    @property
    def scan(self) -> Scan | None:
        """The scan of the reading's picture; None without a picture."""
        return None if self.line_scan is None else self.line_scan.scan


@dataclass(frozen=True)
class Drive:
    """A recorded drive: what the robot saw and where it was."""

    field: Field
    ticks: list[Tick]

    def truth_at(self, stamp: float) -> Pose2:
        """Return the true pose at a stamp [s], interpolated between two readings."""
        after = min(bisect_right(self.ticks, stamp, key=lambda t: t.stamp), len(self.ticks) - 1)
        low, high = self.ticks[max(after - 1, 0)], self.ticks[after]
        part = (stamp - low.stamp) / max(high.stamp - low.stamp, 1e-9)
        return interpolate(low.truth, high.truth, min(max(part, 0.0), 1.0))


def random_pose_on_eight(
    rng: np.random.Generator, elapsed: float, eight: FigureEight | None = None
) -> Pose2:
    """Draw a pose at which a robot may be some time [s] after the start of a figure-eight.

    The path is turned at random about the origin, and the robot is a little off the path.
    """
    eight = eight or FigureEight()
    left = min(elapsed % eight.lap, eight.lap / 2)
    right = elapsed % eight.lap - left
    on_path = eight.twist(0.0).integrate(left) @ eight.twist(eight.lap / 2).integrate(right)
    jitter = Pose2(*rng.normal(0, (0.02, 0.02, 0.1)).tolist())
    return Pose2(theta=float(rng.uniform(-math.pi, math.pi))) @ on_path @ jitter


@dataclass(frozen=True)
class Kidnap:
    """The robot is carried off, and does not notice."""

    stamp: float
    """When [s]; with the next reading."""
    place: Callable[[Pose2], Pose2]
    """Where it is put, by where it is."""
    before: float = 0.0
    """How long it stands before that [s]."""
    after: float = 0.0
    """How long it stands after that [s]."""

    def stands(self, stamp: float) -> bool:
        """Whether the robot stands at a stamp [s]."""
        return self.stamp - self.before <= stamp < self.stamp + self.after


def record(
    config: Config,
    seconds: float,
    *,
    start: Pose2 | None = None,
    elapsed: float = 0.0,
    kidnap: Kidnap | None = None,
    scanner: LineScanner | None = None,
    disturb: Callable[[Robot], Robot] | None = None,
    floor: Field | None = None,
    command: Callable[[float], DriveCommand] | None = None,
) -> Drive:
    """Drive the figure-eight or another way; keep readings and scans, with the filter paused.

    Args:
        config: robot, map, seed and figure-eight.
        seconds: how long to drive [s].
        start: start pose in the map; by default that of the field.
        elapsed: time on the figure-eight at the start [s].
        kidnap: when the robot is carried off, and where to.
        disturb: makes the robot that drives, of the one that the configuration names.
        floor: the field as it truly is; by default as it is drawn.
        command: what is commanded at a stamp [s], instead of the figure-eight.
    """
    field = load_field(config.map, MAPS)
    if start is not None:
        field = replace(field, start=start)
    config = replace(config, figure_eight=replace(config.figure_eight, phase=elapsed))
    # Models are used only when the drive is followed; here a broken one would stop the robot.
    config = replace(config, sensor_model="", motion_model="", models="")
    config, _ = resolve_robot(for_lab(simulated(config)))
    made = _robot(config, floor or field, field.start, disturb)
    program = build_program(config, robot=made, field=field, scanner=scanner)
    engine, robot = silent(program.engine), program.robot
    engine.commands.put(PauseCommand(type="pause"))
    ticks: list[Tick] = []
    try:
        while not ticks or ticks[-1].stamp < seconds:
            stands = kidnap is not None and kidnap.stands(ticks[-1].stamp if ticks else 0.0)
            before = ticks[-1].stamp if ticks else -math.inf
            if stands:
                engine.commands.put(StopCommand(type="stop"))
            elif command is None:
                engine.commands.put(FigureEightCommand(type="figure_eight"))
            else:
                engine.commands.put(command(max(before, 0.0)))
            ticks.append(_tick(engine.step(), looks=_looks_at_pictures(engine)))
            if kidnap is not None and before < kidnap.stamp <= ticks[-1].stamp:
                assert isinstance(robot, RepositionableRobot)
                robot.place(kidnap.place(ticks[-1].truth))
    finally:
        robot.close()
    return Drive(field, ticks)


def _robot(
    config: Config, floor: Field, start: Pose2, disturb: Callable[[Robot], Robot] | None
) -> Robot:
    """Return the configuration's robot on a floor that may be another than the drawing."""
    rng = Streams.of(config.seed).robot
    robot = build_robot(config, robot_spec(config), replace(floor, start=start), rng, no_wait)
    return robot if disturb is None else disturb(robot)


def simulated(config: Config) -> Config:
    """Return the configuration with a simulated robot in place of a real one."""
    return config if robot_kind(config).is_simulated else replace(config, robot=AUTO)


def for_lab(config: Config) -> Config:
    """Return the configuration without a start pose that was saved or set for another run."""
    return replace(config, start_pose=StartPoseSettings())


def silent(engine: Engine) -> Engine:
    """Make an engine log its problems at debug level only.

    In some conditions pictures are missing on purpose.
    """
    engine.controls.problems = Problems(logging.DEBUG)
    return engine


def _looks_at_pictures(engine: Engine) -> bool:
    return isinstance(engine.controls.odometry, PictureAidedOdometry)


def _tick(snapshot: Snapshot, *, looks: bool) -> Tick:
    reading, odometry = snapshot.reading, snapshot.odom_from_robot
    if reading.frame is None:
        return Tick(reading, odometry)
    if not looks:
        reading = replace(reading, frame=Frame(reading.frame.stamp, NO_PICTURE))
    return Tick(reading, odometry, snapshot.filter.line_scan, snapshot.odom_from_scan)


class RecordedScanner(LineScanner):
    """A scanner that looks up the recorded line scans of a drive."""

    def __init__(self, drive: Drive, spec: RobotSpec, settings: LineScannerSettings) -> None:
        super().__init__(spec.floor_view, settings)
        self._scans = {
            tick.line_scan.scan.stamp: tick.line_scan
            for tick in drive.ticks
            if tick.line_scan is not None
        }

    def scan(self, frame: Frame, twist: Twist2 = Twist2()) -> LineScan:
        """Return the recorded line scan with the picture's stamp."""
        return self._scans[frame.stamp]


def follow_drive(
    drive: Drive,
    config: Config,
    begin: Callable[[Localization], None],
    *,
    believed: Field | None = None,
    entries: EntryField | None = None,
) -> Iterator[tuple[Tick, Pose2, Localization]]:
    """Let the program follow a recorded drive, with the engine that also runs live.

    Yields each tick with a picture, the odometry at that picture, and the localization after it.

    Args:
        drive: what the robot saw and where it was.
        config: seed, localization and the user's own models.
        begin: called once before the first tick; says where the filter starts.
        believed: the field that the filter assumes; by default the true one.
        entries: the distance table of that field, if it is already built.

    Raises:
        EvaluationError: one of the user's own models is broken.
    """
    spec = robot_spec(config)
    program = build_program(
        for_lab(config),
        robot=ReplayRobot("The drive", (tick.reading for tick in drive.ticks), spec),
        field=believed or drive.field,
        scanner=RecordedScanner(drive, spec, config.scanner),
        entries=entries,
    )
    engine = silent(program.engine)
    localization = engine.localization
    begin(localization)
    for tick in drive.ticks:
        engine.step()
        if localization.fault:
            raise EvaluationError(localization.fault)
        if tick.odometry_at_scan is not None:
            yield tick, tick.odometry_at_scan, localization
