"""All commands in one table: how each is checked, carried out, and repeated in a replay."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from app.engine.calibration_commands import (
    check_calibrated_by_tape,
    check_calibration,
    profile_after,
)
from app.engine.controls import Controls
from app.engine.driving_commands import (
    calibrate,
    check_drawn,
    check_driving,
    check_figure_eight,
    drive,
    explore,
    figure_eight,
    stop,
)
from app.engine.fault_commands import check_faults, set_faults
from app.engine.hand_commands import (
    check_particles_filter,
    filter_by_hand,
    filter_step,
    filter_undo,
)
from app.engine.own_models.own_models import OwnChoice
from app.engine.parameter_changes import with_values_and_models
from app.engine.pose_commands import (
    check_inside,
    check_particles,
    check_placeable,
    check_pose,
    check_room,
    place,
    scatter,
    set_particles,
    set_pose,
    undo,
)
from app.engine.program import Program
from app.engine.rule import Repeat, Rule, nothing
from app.messages.commands import (
    CloseRecordingCommand,
    Command,
    OpenRecordingCommand,
    PauseCommand,
    PingCommand,
    PlaceCommand,
    RecordCommand,
    ReplayCommand,
    ResetCommand,
    ResumeCommand,
    RunAgainCommand,
    ScatterCommand,
    SetCalibrationCommand,
    SetFaultsCommand,
    SetParametersCommand,
    SetParticlesCommand,
    SetPoseCommand,
    ShowCommand,
    UndoCommand,
    UpdateCommand,
    UseFieldCommand,
)
from app.messages.driving_commands import (
    CalibrateCommand,
    DriveCommand,
    FigureEightCommand,
    FinishCalibrationCommand,
    StopCommand,
    TakeCommand,
    UndoCalibrationCommand,
)
from app.messages.hand_commands import FilterByHandCommand, FilterStepCommand, FilterUndoCommand
from app.messages.map_commands import (
    DeleteStrokeCommand,
    DiscardMapCommand,
    ExploreCommand,
    FinishMapCommand,
    JoinStrokesCommand,
    MoveEndCommand,
    PauseMapCommand,
    SaveMapCommand,
    StartMapCommand,
)
from robot.driving.odometry import OdometryState
from robot.errors import BrickPoseError, CommandError

MOST_WAITING = 1000
"""Most commands that may wait: if the engine hangs, a flood of them must not fill the memory."""


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
        DriveCommand: Rule(drive, Repeat.NEVER, check_driving, drives=True),
        FigureEightCommand: Rule(figure_eight, Repeat.NEVER, check_figure_eight, drives=True),
        CalibrateCommand: Rule(
            calibrate, Repeat.NEVER, check_driving, check_calibrated_by_tape, drives=True
        ),
        FinishCalibrationCommand: Rule(nothing, Repeat.NEVER, check_driving),
        UndoCalibrationCommand: Rule(nothing, Repeat.NEVER, check_driving),
        StartMapCommand: Rule(nothing, Repeat.NEVER, check_drawn, slow=True),
        PauseMapCommand: Rule(nothing, Repeat.NEVER, check_driving),
        ExploreCommand: Rule(explore, Repeat.NEVER, check_driving, drives=True),
        FinishMapCommand: Rule(nothing, Repeat.NEVER, check_driving),
        DeleteStrokeCommand: Rule(nothing, Repeat.NEVER, check_driving, slow=True),
        MoveEndCommand: Rule(nothing, Repeat.NEVER, check_driving, slow=True),
        JoinStrokesCommand: Rule(nothing, Repeat.NEVER, check_driving, slow=True),
        DiscardMapCommand: Rule(nothing, Repeat.NEVER, check_driving, slow=True),
        SaveMapCommand: Rule(nothing, Repeat.NEVER, check_driving, slow=True),
        StopCommand: Rule(stop, Repeat.NEVER),
        TakeCommand: Rule(nothing, Repeat.NEVER, check_driving),
        SetPoseCommand: Rule(set_pose, Repeat.MOMENT, check_field=check_pose),
        SetParticlesCommand: Rule(set_particles, Repeat.MOMENT, check_room, check_particles),
        ScatterCommand: Rule(scatter, Repeat.MOMENT),
        UndoCommand: Rule(undo, Repeat.MOMENT),
        PauseCommand: Rule(_pause, Repeat.MOMENT),
        ResumeCommand: Rule(_resume, Repeat.MOMENT),
        UpdateCommand: Rule(_update, Repeat.MOMENT),
        FilterByHandCommand: Rule(filter_by_hand, Repeat.MOMENT, check_particles_filter),
        FilterStepCommand: Rule(filter_step, Repeat.MOMENT, check_particles_filter),
        FilterUndoCommand: Rule(filter_undo, Repeat.MOMENT, check_particles_filter),
        PlaceCommand: Rule(place, Repeat.RECORDED, check_placeable, check_inside),
        ResetCommand: Rule(_reset, Repeat.SETTING),
        SetParametersCommand: Rule(_set_parameters, Repeat.SETTING, _check_parameters),
        SetCalibrationCommand: Rule(_set_calibration, Repeat.MOMENT, check_field=check_calibration),
        SetFaultsCommand: Rule(set_faults, Repeat.NEVER, check_faults, slow=True),
        UseFieldCommand: Rule(nothing, Repeat.NEVER, check_driving, slow=True),
        ShowCommand: Rule(_show, Repeat.NEVER),
        ReplayCommand: Rule(nothing, Repeat.NEVER, _check_replay),
        OpenRecordingCommand: Rule(nothing, Repeat.NEVER, slow=True),
        RunAgainCommand: Rule(nothing, Repeat.NEVER, slow=True),
        CloseRecordingCommand: Rule(nothing, Repeat.NEVER, _check_replay, slow=True),
        RecordCommand: Rule(nothing, Repeat.NEVER),
        PingCommand: Rule(nothing, Repeat.NEVER),
    }
)
"""Rules by command; those that only outputs carry out, such as ``RecordCommand``, never reach the
engine."""
