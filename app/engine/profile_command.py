"""The command that sets what is known of the robot, and what is known after it."""

from __future__ import annotations

from dataclasses import replace

from app.engine.command_row import CommandRow, Repeat, TickContext
from app.messages.commands import SetCalibrationCommand
from robot.description.profile import Profile, check_values
from robot.description.spec import RobotSpec
from robot.description.unknowns import NAMES, ROBOT
from robot.description.urdf import SpecError
from robot.errors import CommandError
from robot.fields.field import Field


def profile_after(command: SetCalibrationCommand, spec: RobotSpec) -> Profile:
    """Return the profile of a robot after a command that was checked."""
    profile = Profile.of(spec).changed(command.values, command.sd, command.made, command.source)
    return profile if command.fit is None else replace(profile, fit=command.fit)


def calibration_command(profile: Profile) -> SetCalibrationCommand:
    """Return the command that sets a profile; the lens is not changed."""
    names = NAMES[:ROBOT]
    return SetCalibrationCommand(
        type="set_calibration",
        values=dict(zip(names, profile.values.tolist(), strict=True)),
        sd=dict(zip(names, profile.sd.tolist(), strict=True)),
        made=profile.made,
        source=profile.source,
        fit=dict(profile.fit),
    )


def _set(tick: TickContext[SetCalibrationCommand]) -> None:
    tick.controls.calibrate(profile_after(tick.command, tick.controls.spec))


def _check_values(command: SetCalibrationCommand, _field: Field) -> None:
    """Refuse a calibration that no robot has; name what is valid."""
    try:
        check_values(command.values, command.sd)
    except SpecError as error:
        raise CommandError(str(error)) from error


COMMANDS = (CommandRow(SetCalibrationCommand, _set, Repeat.MOMENT, check_field=_check_values),)
