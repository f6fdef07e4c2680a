"""Commands that drive the robot, and one that stops it."""

from __future__ import annotations

from app.engine.command_row import CommandRow, TickContext
from app.engine.program import Program
from app.messages.driving_commands import DriveCommand, FigureEightCommand, StopCommand, TakeCommand
from robot.errors import CommandError
from robot.geometry import Twist2

LEFT_M = 0.05
"""A robot whose middle is farther than this beyond the tape has left the field."""


def require_drivable(program: Program) -> None:
    """Refuse the drive in a replay, and while the robot is faulty."""
    if program.loop is not None:
        raise CommandError("this is a replay, which cannot be driven")
    latest = program.engine.latest.get()
    if latest is not None and latest.filter.fault is not None:
        raise CommandError(f"the robot stands still until this is fixed: {latest.filter.fault}")


def _drive(tick: TickContext[DriveCommand]) -> None:
    twist = Twist2(tick.command.v, tick.command.omega)
    tick.controls.driving.drive(twist, tick.controls.stamp)


def _figure_eight(tick: TickContext[FigureEightCommand]) -> None:
    command, controls = tick.command, tick.controls
    controls.driving.figure_eight(controls.stamp, command.speed, start=command.start)


def _check_figure_eight(command: FigureEightCommand, program: Program) -> None:
    """Refuse a figure-eight that would leave the field."""
    latest = program.engine.latest.get()
    # While the place is unknown, nobody can say whether the figure-eight fits.
    if not command.start or latest is None or latest.pose is None or not latest.knows_place:
        return
    path, field = program.config.figure_eight.path(), program.field
    beyond = field.farthest_outside(latest.pose.apply(path))
    if beyond > LEFT_M and field.farthest_outside(field.start.apply(path)) > LEFT_M:
        raise CommandError(
            f"the figure-eight would leave this field by {1000 * beyond:.0f} mm, and from the "
            "start, too; take a larger field, or drive by hand"
        )
    if beyond > LEFT_M:
        raise CommandError(
            f"from here the figure-eight would leave the field by {1000 * beyond:.0f} mm; drive "
            "to where it fits, or go back to the start"
        )


def _stop(tick: TickContext[StopCommand]) -> None:
    tick.controls.driving.stop()


COMMANDS = (
    CommandRow(DriveCommand, _drive, allowed=require_drivable, drives=True),
    CommandRow(
        FigureEightCommand,
        _figure_eight,
        allowed=require_drivable,
        check=_check_figure_eight,
        drives=True,
    ),
    CommandRow(StopCommand, _stop, urgent=True),
    # Whoever decides who drives takes it, and passes nothing on.
    CommandRow(TakeCommand, allowed=require_drivable),
)
