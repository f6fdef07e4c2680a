"""All commands in one table: how each is checked, carried out, and repeated in a replay."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum, auto
from types import MappingProxyType
from typing import Any

from app.engine.calibration_commands import (
    check_calibrated_by_tape,
    check_calibration,
    profile_after,
)
from app.engine.controls import Controls
from app.engine.fault_commands import check_faults, set_faults
from app.engine.own_models.own_models import OwnChoice
from app.engine.parameter_changes import with_values_and_models
from app.engine.pose_commands import cloud_of, covariance_of
from app.engine.program import Program
from app.messages.commands import (
    CalibrateCommand,
    CloseRecordingCommand,
    Command,
    DeleteStrokeCommand,
    DiscardMapCommand,
    DriveCommand,
    ExploreCommand,
    FigureEightCommand,
    FinishCalibrationCommand,
    FinishMapCommand,
    JoinStrokesCommand,
    MoveEndCommand,
    OpenRecordingCommand,
    PauseCommand,
    PauseMapCommand,
    PingCommand,
    PlaceCommand,
    RecordCommand,
    ReplayCommand,
    ResetCommand,
    ResumeCommand,
    SaveMapCommand,
    ScatterCommand,
    SetCalibrationCommand,
    SetFaultsCommand,
    SetParametersCommand,
    SetParticlesCommand,
    SetPoseCommand,
    ShowCommand,
    StartMapCommand,
    StopCommand,
    TakeCommand,
    UndoCalibrationCommand,
    UndoCommand,
    UpdateCommand,
    UseFieldCommand,
)
from robot.covariance import CovarianceError
from robot.driving.odometry import OdometryState
from robot.errors import BrickPoseError, CommandError
from robot.fields.field import Field
from robot.geometry import Pose2, Twist2
from robot.interface import RepositionableRobot

LEFT_M = 0.05
"""A robot whose middle is farther than this beyond the tape has left the field."""

MOST_WAITING = 1000
"""Most commands that may wait: if the engine hangs, a flood of them must not fill the memory."""
MOST_WAITING_SETS = 20
"""A set of poses is refused if this many commands wait already: it may be large."""


class Repeat(Enum):
    """How a replay repeats a recorded command, and how long a viewer's own command holds there."""

    NEVER = auto()
    """Not repeated: a recording cannot be driven; or the filter does not need the command."""
    RECORDED = auto()
    """Carried out as recorded."""
    MOMENT = auto()
    """Carried out as recorded; a viewer's own command holds until somebody seeks."""
    SETTING = auto()
    """Carried out as recorded, but a viewer's own command overrides it for the whole replay."""


def _nothing(*_: object) -> None:
    pass


@dataclass(frozen=True)
class Rule:
    """How commands of one type are checked, carried out and repeated."""

    apply: Callable[[Any, Controls, OdometryState], None]
    """Carries the command out, in the engine's thread."""
    repeat: Repeat
    check: Callable[[Any, Program], None] = _nothing
    """Raises a CommandError if this robot or these parameters do not allow the command."""
    check_field: Callable[[Any, Field], None] = _nothing
    """Raises a CommandError if the field does not allow it, or the numbers make no sense; replays
    ask it of recorded commands as well."""
    drives: bool = False
    """Whether the robot has to stop when everybody has left who sent such commands."""
    slow: bool = False
    """Whether it may take more than some milliseconds; an event loop leaves it to a thread."""


def check(command: Command, program: Program) -> None:
    """Refuse a command that this field, this robot or these parameters do not allow.

    A command is also refused if the engine has failed or too many commands wait; but from a replay
    that has failed there is a way back to the robot.

    Raises:
        CommandError: the command is refused; the message says why.
    """
    engine, rule = program.engine, RULES[type(command)]
    if not isinstance(command, PingCommand):
        if engine.failure is not None and not isinstance(command, CloseRecordingCommand):
            raise CommandError(engine.failure)
        if len(engine.commands) >= MOST_WAITING and not isinstance(command, StopCommand):
            raise CommandError(
                f"{MOST_WAITING} commands wait already; send fewer, or wait for answers"
            )
    rule.check(command, program)
    rule.check_field(command, program.field)


def apply(command: Command, controls: Controls, odometry: OdometryState) -> None:
    """Carry out a checked command."""
    RULES[type(command)].apply(command, controls, odometry)


def _drive(command: DriveCommand, controls: Controls, _odometry: OdometryState) -> None:
    controls.driving.drive(Twist2(command.v, command.omega), controls.stamp)


def _figure_eight(
    command: FigureEightCommand, controls: Controls, _odometry: OdometryState
) -> None:
    controls.driving.figure_eight(controls.stamp, command.speed)


def _check_figure_eight(command: FigureEightCommand, program: Program) -> None:
    _check_driving(command, program)
    latest = program.engine.latest.get()
    # Where nobody knows the place, nobody knows whether it fits either.
    if not command.start or latest is None or latest.pose is None or not latest.knows_place:
        return
    way = program.engine.controls.driving.figure_eight_path(latest.pose)
    beyond = program.field.farthest_outside(way)
    if beyond > LEFT_M:
        raise CommandError(
            f"from here the figure-eight would leave the field by {1000 * beyond:.0f} mm; drive "
            "to where it fits, or go back to the start"
        )


def _calibrate(command: CalibrateCommand, controls: Controls, _odometry: OdometryState) -> None:
    controls.driving.calibrate(controls.stamp, start=command.start)


def _explore(command: ExploreCommand, controls: Controls, _odometry: OdometryState) -> None:
    controls.driving.explore(controls.stamp, start=command.start)


def _check_driving(_command: Command, program: Program) -> None:
    if program.loop is not None:
        raise CommandError("this is a replay; only a robot that is there can be driven")
    latest = program.engine.latest.get()
    if latest is not None and latest.fault is not None:
        raise CommandError(f"the robot stands still until this is mended: {latest.fault}")


def _check_drawn(command: Command, program: Program) -> None:
    _check_driving(command, program)
    if program.field.tape_width is None:
        raise CommandError(f"the field {program.field.name} is not of tape; maps are of tape")


def _stop(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    controls.driving.stop()


def _set_pose(command: SetPoseCommand, controls: Controls, _odometry: OdometryState) -> None:
    controls.localization.keep_belief()
    pose, covariance = Pose2(command.x, command.y, command.theta), covariance_of(command)
    if covariance is None:
        controls.localization.set_pose(pose, command.sd_xy, command.sd_theta)
    else:
        controls.localization.set_pose_with(pose, covariance)


def _check_pose(command: SetPoseCommand, field: Field) -> None:
    _require_inside(Pose2(command.x, command.y, command.theta), field)
    try:
        covariance_of(command)
    except CovarianceError as error:
        raise CommandError(str(error)) from error


def _set_particles(
    command: SetParticlesCommand, controls: Controls, _odometry: OdometryState
) -> None:
    controls.localization.keep_belief()
    controls.localization.set_cloud(cloud_of(command))


def _check_room(_command: SetParticlesCommand, program: Program) -> None:
    if len(program.engine.commands) >= MOST_WAITING_SETS:
        raise CommandError("commands wait already; a set of poses would fill the memory")


def _check_particles(command: SetParticlesCommand, field: Field) -> None:
    for pose in command.poses:
        _require_inside(Pose2(*pose), field)
    cloud_of(command)


def _place(command: PlaceCommand, controls: Controls, odometry: OdometryState) -> None:
    controls.place(Pose2(command.x, command.y, command.theta), odometry)


def _check_placeable(_command: PlaceCommand, program: Program) -> None:
    if not isinstance(program.robot, RepositionableRobot):
        raise CommandError(f"{program.robot.name} can only be moved by hand")


def _check_inside(command: PlaceCommand, field: Field) -> None:
    _require_inside(Pose2(command.x, command.y, command.theta), field)


def _require_inside(pose: Pose2, field: Field) -> None:
    if not field.contains(pose):
        xmin, ymin, xmax, ymax = (1000.0 * edge for edge in field.extent)
        raise CommandError(
            f"x {1000.0 * pose.x:.0f} mm, y {1000.0 * pose.y:.0f} mm is off the map; x is "
            f"{xmin:.0f} to {xmax:.0f} mm and y is {ymin:.0f} to {ymax:.0f} mm"
        )


def _scatter(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    controls.localization.keep_belief()
    controls.localization.scatter()


def _undo(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    if controls.localization.undoable:
        controls.localization.undo()
    else:
        controls.problems.note(controls.stamp, "There was nothing to undo.")


def _pause(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    controls.localization.paused = True


def _resume(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    controls.localization.paused = False


def _update(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    controls.localization.update_once()


def _reset(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    controls.reset()


def _set_parameters(
    command: SetParametersCommand, controls: Controls, _odometry: OdometryState
) -> None:
    controls.set_parameters(command.values)


def _check_parameters(command: SetParametersCommand, program: Program) -> None:
    latest = program.engine.latest.get()
    current = latest.parameters if latest else program.config.localization
    try:
        with_values_and_models(current, latest.own if latest else OwnChoice(), command.values)
    except BrickPoseError as error:
        raise CommandError(str(error)) from error


def _set_calibration(
    command: SetCalibrationCommand, controls: Controls, _odometry: OdometryState
) -> None:
    controls.calibrate(profile_after(command, controls.spec))


def _show(command: ShowCommand, controls: Controls, _odometry: OdometryState) -> None:
    shown = {command.layer} if command.visible else set()
    controls.layers = controls.layers - {command.layer} | shown


def _check_replay(_command: Command, program: Program) -> None:
    if program.loop is None:
        raise CommandError("this is no replay; brickpose replay FILE starts one")


RULES: Mapping[type[Command], Rule] = MappingProxyType(
    {
        DriveCommand: Rule(_drive, Repeat.NEVER, _check_driving, drives=True),
        FigureEightCommand: Rule(_figure_eight, Repeat.NEVER, _check_figure_eight, drives=True),
        CalibrateCommand: Rule(
            _calibrate, Repeat.NEVER, _check_driving, check_calibrated_by_tape, drives=True
        ),
        FinishCalibrationCommand: Rule(_nothing, Repeat.NEVER, _check_driving),
        UndoCalibrationCommand: Rule(_nothing, Repeat.NEVER, _check_driving),
        StartMapCommand: Rule(_nothing, Repeat.NEVER, _check_drawn, slow=True),
        PauseMapCommand: Rule(_nothing, Repeat.NEVER, _check_driving),
        ExploreCommand: Rule(_explore, Repeat.NEVER, _check_driving, drives=True),
        FinishMapCommand: Rule(_nothing, Repeat.NEVER, _check_driving),
        DeleteStrokeCommand: Rule(_nothing, Repeat.NEVER, _check_driving, slow=True),
        MoveEndCommand: Rule(_nothing, Repeat.NEVER, _check_driving, slow=True),
        JoinStrokesCommand: Rule(_nothing, Repeat.NEVER, _check_driving, slow=True),
        DiscardMapCommand: Rule(_nothing, Repeat.NEVER, _check_driving, slow=True),
        SaveMapCommand: Rule(_nothing, Repeat.NEVER, _check_driving, slow=True),
        StopCommand: Rule(_stop, Repeat.NEVER),
        TakeCommand: Rule(_nothing, Repeat.NEVER, _check_driving),
        SetPoseCommand: Rule(_set_pose, Repeat.MOMENT, check_field=_check_pose),
        SetParticlesCommand: Rule(_set_particles, Repeat.MOMENT, _check_room, _check_particles),
        ScatterCommand: Rule(_scatter, Repeat.MOMENT),
        UndoCommand: Rule(_undo, Repeat.MOMENT),
        PauseCommand: Rule(_pause, Repeat.MOMENT),
        ResumeCommand: Rule(_resume, Repeat.MOMENT),
        UpdateCommand: Rule(_update, Repeat.MOMENT),
        PlaceCommand: Rule(_place, Repeat.RECORDED, _check_placeable, _check_inside),
        ResetCommand: Rule(_reset, Repeat.SETTING),
        SetParametersCommand: Rule(_set_parameters, Repeat.SETTING, _check_parameters),
        SetCalibrationCommand: Rule(_set_calibration, Repeat.MOMENT, check_field=check_calibration),
        SetFaultsCommand: Rule(set_faults, Repeat.NEVER, check_faults, slow=True),
        UseFieldCommand: Rule(_nothing, Repeat.NEVER, _check_driving, slow=True),
        ShowCommand: Rule(_show, Repeat.NEVER),
        ReplayCommand: Rule(_nothing, Repeat.NEVER, _check_replay),
        OpenRecordingCommand: Rule(_nothing, Repeat.NEVER, slow=True),
        CloseRecordingCommand: Rule(_nothing, Repeat.NEVER, _check_replay, slow=True),
        RecordCommand: Rule(_nothing, Repeat.NEVER),
        PingCommand: Rule(_nothing, Repeat.NEVER),
    }
)
"""Rules by command; those that only outputs carry out, such as ``RecordCommand``, never reach the
engine."""
