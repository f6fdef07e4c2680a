"""Builds the program from its parts; the only module that seeds, connects and starts them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace

import numpy as np

from app.engine.added_models import AddedModels, choice_of
from app.engine.commands import apply
from app.engine.companions import Companions
from app.engine.controls import Controls
from app.engine.driving import Driving
from app.engine.engine import Engine
from app.engine.follower import Follower
from app.engine.localization import Localization
from app.engine.parameter_changes import changed_values
from app.engine.plugging import companions_of, models_of, start_of
from app.engine.profile_command import calibration_command
from app.engine.program import LocalProgram
from app.engine.robot_facts import close_robot
from app.engine.robots import build_robot, resolve_robot, robot_kind, robot_spec
from app.engine.start import Start, start
from app.messages.commands import SetParametersCommand
from app.settings.config import MAPS, Config
from app.settings.groups import InitialPose
from robot.description.profile import Profile
from robot.driving.differential_drive import DifferentialDrive
from robot.driving.drive_controller import DriveController
from robot.driving.odometry import Odometry
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Pose2
from robot.interface import RepositionableRobot, Robot
from robot.localization.estimate import Hypothesis
from robot.localization.models.entry_field import EntryField
from robot.localization.parameters import LocalizationParameters
from robot.scanning.line_scanner import LineScanner
from sim.simulated import SimulatedRobot, no_wait


@dataclass(frozen=True, slots=True)
class Streams:
    """Independent random generators: what the filter draws does not change what the robot draws."""

    robot: np.random.Generator
    filter: np.random.Generator

    @classmethod
    def of(cls, seed: int) -> Streams:
        """Return the generators of a seed; drives and replays with this seed draw the same."""
        return cls(*np.random.default_rng(seed).spawn(2))


def build_program(
    config: Config,
    wait: Callable[[float], None] = no_wait,
    *,
    robot: Robot | None = None,
    field: Field | None = None,
    scanner: LineScanner | None = None,
    entries: EntryField | None = None,
) -> LocalProgram:
    """Build robot and engine.

    A real robot is active from here on, so the caller must close it.

    Args:
        config: everything that can be set.
        wait: called with each stamp of a simulated robot; ``RealTime()`` makes it run in real time.
        robot: used instead of the robot that the configuration names.
        field: used instead of the map that the configuration names.
        scanner: used instead of a new line scanner.
        entries: the field's table of distances, if it exists already.

    Raises:
        ValueError: the field or the robot's description cannot be used.
        PackageError: the configuration names the simulator, which is not installed.
    """
    config, _ = resolve_robot(config)
    field = field or load_field(config.map, MAPS)
    added = models_of(config, field)
    begin = start_of(config, field)
    if robot is None:
        rng = Streams.of(config.seed).robot
        robot = build_robot(config, robot_spec(config), field, rng, wait)
    with ExitStack() as failing:
        failing.callback(robot.close)
        # It knows itself best: a robot that was given, or does not take its description from us.
        scanner = scanner or LineScanner(robot.spec.floor_view, config.scanner, field.tape)
        if begin.truth is not None and isinstance(robot, RepositionableRobot):
            robot.place(begin.truth)
        engine = build_engine(
            config,
            robot,
            field,
            scanner,
            added=added,
            begin=begin,
            parameters=config.localization,
            entries=entries,
        )
        failing.pop_all()
    if begin.complaint is not None:
        engine.note(begin.complaint)
    return LocalProgram(engine, robot, field, config, choice_of(added))


def build_on_map(program: LocalProgram, name: str, field: Field, place: Hypothesis) -> LocalProgram:
    """Build a program on another map, with the robot of one that has ended but handed it over.

    The robot's calibration and the filter's parameters go on as they are.

    Args:
        program: the one that has ended.
        name: of the map, as ``Config.map``.
        field: the map.
        place: where the robot is in it.

    Raises:
        FieldError: the robot is off the map.
    """
    # A recording's replay begins where the configuration says.
    pose, covariance = place.pose, tuple(place.covariance.ravel().tolist())
    initial = InitialPose(pose.x, pose.y, pose.theta, covariance=covariance)
    begins = replace(program.config.start_pose, set_initial_pose=True, initial_pose=initial)
    config = replace(program.config, map=name, start_pose=replace(begins, restore_pose=False))
    controls, robot = program.engine.controls, program.robot
    scanner = LineScanner(controls.spec.floor_view, config.scanner, field.tape)
    added, begin = models_of(config, field), replace(start(begins, field), odometry=pose)
    parameters = controls.localization.parameters
    engine = build_engine(
        config, robot, field, scanner, added=added, begin=begin, parameters=parameters
    )
    if controls.spec is not robot.spec:
        engine.commands.put(calibration_command(Profile.of(controls.spec)))
    return LocalProgram(engine, robot, field, config, choice_of(added))


def build_on_field(
    program: LocalProgram, name: str, field: Field, wait: Callable[[float], None] = no_wait
) -> LocalProgram:
    """Build a program on another field, after one that has ended but handed its robot over.

    A simulated robot stands at the start of the new field, with its faults; a real one has to be
    put there. The filter's parameters go on as they are.

    Args:
        program: the one that has ended.
        name: of the field, as ``Config.map``.
        field: the field.
        wait: of a simulated robot, as in ``build_program``.
    """
    robot, parameters = program.robot, program.engine.controls.localization.parameters
    if not (isinstance(robot, SimulatedRobot) or robot_kind(program.config).is_simulated):
        place = Hypothesis(1.0, field.start, parameters.filter.initial_covariance)
        return build_on_map(program, name, field, place)
    close_robot(robot)
    begins = replace(program.config.start_pose, restore_pose=False, set_initial_pose=False)
    config = replace(program.config, map=name, start_pose=begins)
    following = build_program(config, wait, field=field)
    if isinstance(robot, SimulatedRobot):
        _keep_faults(robot, following.robot)
    values = changed_values(parameters, program.config.localization)
    if values:
        following.engine.commands.put(SetParametersCommand(type="set_parameters", values=values))
    return following


def _keep_faults(before: SimulatedRobot, following: Robot) -> None:
    if isinstance(following, SimulatedRobot) and before.settings != following.settings:
        following.change(before.settings)


def build_engine(
    config: Config,
    robot: Robot,
    field: Field,
    scanner: LineScanner,
    *,
    added: tuple[AddedModels, ...],
    begin: Start,
    parameters: LocalizationParameters,
    entries: EntryField | None = None,
) -> Engine:
    """Build an engine before its first tick; a replay builds a new one whenever it starts again.

    Args:
        config: everything that can be set; a reset restores its parameters.
        robot: the robot that the engine steps.
        field: the map.
        scanner: finds tape in pictures.
        added: models of features.
        begin: where filter and odometry start.
        parameters: the filter's parameters at the start.
        entries: the field's table of distances, if it exists already.
    """
    localization = Localization(
        scanner,
        field,
        parameters,
        Streams.of(config.seed).filter,
        added=added,
        entries=entries,
        start=begin.hypotheses,
        configured=config.localization,
        spec=robot.spec,
    )
    companions = companions_of(config, robot, field)
    start_pose = _odometry_start(begin, robot, field)
    return connect(config, robot, localization, start_pose, companions=companions)


def connect(
    config: Config,
    robot: Robot,
    follower: Follower,
    start_pose: Pose2 = Pose2(),
    driving: Driving | None = None,
    companions: Companions | None = None,
) -> Engine:
    """Connect given parts to an engine before its first tick.

    Args:
        config: settings of odometry and drive.
        robot: the robot that the engine steps: a real, simulated or recorded one.
        follower: follows the robot by its pictures or scans; ``Follower()`` is none.
        start_pose: the robot's pose in the map where dead reckoning begins.
        driving: decides where to drive; by default as commands say.
        companions: what features do in each tick; None is nothing.
    """
    kinematics = DifferentialDrive(robot.spec, config.drive.multipliers)
    driving = driving or Driving(
        DriveController(kinematics, config.drive),
        config.drive.cmd_vel_timeout,
        config.figure_eight,
    )
    odometry = Odometry(kinematics, config.odometry)
    return Engine(Controls(robot, odometry, follower, driving, start_pose), apply, companions)


def _odometry_start(begin: Start, robot: Robot, field: Field) -> Pose2:
    """Return the robot's pose at the start of dead reckoning, as far as it is known."""
    if begin.odometry is not None:
        return begin.odometry
    if isinstance(robot, RepositionableRobot):
        return begin.truth or field.start
    return begin.hypotheses[0].pose if begin.hypotheses else field.start
