"""Commands of the drive that calibrates the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from app.engine.command_row import CommandRow, Part, Request, TickContext
from app.engine.driving import Programme
from app.engine.driving_commands import require_drivable
from app.engine.program import Program
from app.features.calibration.messages import (
    CalibrateCommand,
    FinishCalibrationCommand,
    UndoCalibrationCommand,
)
from robot.calibration.programme import LONGEST_S, velocity
from robot.errors import CommandError

if TYPE_CHECKING:
    from app.features.calibration.drive_calibrator import DriveCalibrator

DRIVE = Programme("calibrate", velocity, LONGEST_S)
CALIBRATOR: Part[DriveCalibrator] = Part("calibrator")


def _require_tape(program: Program) -> None:
    """Refuse a drive in a replay, and on a field without tape."""
    require_drivable(program)
    if program.field.tape_width is None:
        raise CommandError(f"the field {program.field.name} is not of tape; valid is a drawn field")


def _begin(request: Request[CalibrateCommand]) -> None:
    """Begin or continue the drive, unless the last one is not adjusted yet."""
    if not request.command.start:
        request.pass_on()
        return
    request.part(CALIBRATOR).require_collected()
    request.pass_on()
    request.part(CALIBRATOR).begin()


def _drive(tick: TickContext[CalibrateCommand]) -> None:
    tick.controls.driving.perform(DRIVE, tick.controls.stamp, start=tick.command.start)


def _finish(request: Request[FinishCalibrationCommand]) -> None:
    request.part(CALIBRATOR).finish()


def _undo(request: Request[UndoCalibrationCommand]) -> None:
    request.part(CALIBRATOR).undo()


COMMANDS = (
    CommandRow(CalibrateCommand, _drive, act=_begin, allowed=_require_tape, drives=True),
    CommandRow(FinishCalibrationCommand, act=_finish, allowed=require_drivable),
    CommandRow(UndoCalibrationCommand, act=_undo, allowed=require_drivable),
)
