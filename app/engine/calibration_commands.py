"""Commands that change what is known of the robot."""

from __future__ import annotations

from app.messages.commands import SetCalibrationCommand
from app.messages.driving_commands import CalibrateCommand
from robot.calibration.profile import Profile, check_values
from robot.calibration.unknowns import NAMES, ROBOT
from robot.description.spec import RobotSpec
from robot.description.urdf import SpecError
from robot.errors import CommandError
from robot.fields.field import Field


def check_calibrated_by_tape(_command: CalibrateCommand, field: Field) -> None:
    """Refuse a drive on a field without tape.

    Raises:
        CommandError: the field is not of tape.
    """
    if field.tape_width is None:
        raise CommandError(f"the field {field.name} is not of tape; valid is a drawn field")


def check_calibration(command: SetCalibrationCommand, _field: Field) -> None:
    """Refuse a calibration that no robot has.

    Raises:
        CommandError: a name is unknown, or a value impossible; names what is valid.
    """
    try:
        check_values(command.values, command.sd)
    except SpecError as error:
        raise CommandError(str(error)) from error


def profile_after(command: SetCalibrationCommand, spec: RobotSpec) -> Profile:
    """Return the profile of a robot after a command that was checked."""
    return Profile.of(spec).changed(command.values, command.sd, command.made, command.source)


def calibration_command(profile: Profile) -> SetCalibrationCommand:
    """Return the command that sets a profile; the lens is not changed."""
    names = NAMES[:ROBOT]
    return SetCalibrationCommand(
        type="set_calibration",
        values=dict(zip(names, profile.values.tolist(), strict=True)),
        sd=dict(zip(names, profile.sd.tolist(), strict=True)),
        made=profile.made,
        source=profile.source,
    )
