"""Checks and carries out commands that drive the robot."""

from __future__ import annotations

from app.engine.controls import Controls
from app.engine.program import Program
from app.messages.commands import Command
from app.messages.driving_commands import CalibrateCommand, DriveCommand, FigureEightCommand
from app.messages.map_commands import ExploreCommand
from robot.driving.odometry import OdometryState
from robot.errors import CommandError
from robot.geometry import Twist2

LEFT_M = 0.05
"""A robot whose middle is farther than this beyond the tape has left the field."""


def drive(command: DriveCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Drive with given velocities."""
    controls.driving.drive(Twist2(command.v, command.omega), controls.stamp)


def figure_eight(command: FigureEightCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Begin or continue the figure-eight."""
    controls.driving.figure_eight(controls.stamp, command.speed, start=command.start)


def check_figure_eight(command: FigureEightCommand, program: Program) -> None:
    """Refuse a figure-eight that would leave the field."""
    check_driving(command, program)
    latest = program.engine.latest.get()
    # While the place is unknown, nobody can say whether the figure-eight fits.
    if not command.start or latest is None or latest.pose is None or not latest.knows_place:
        return
    way = program.engine.controls.driving.figure_eight_path(latest.pose)
    beyond = program.field.farthest_outside(way)
    if beyond > LEFT_M:
        raise CommandError(
            f"from here the figure-eight would leave the field by {1000 * beyond:.0f} mm; drive "
            "to where it fits, or go back to the start"
        )


def calibrate(command: CalibrateCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Begin or continue the drive that calibrates."""
    controls.driving.calibrate(controls.stamp, start=command.start)


def explore(command: ExploreCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Begin or continue to explore."""
    controls.driving.explore(controls.stamp, start=command.start)


def stop(_command: Command, controls: Controls, _odometry: OdometryState) -> None:
    """Stand still."""
    controls.driving.stop()


def check_driving(_command: Command, program: Program) -> None:
    """Refuse the drive in a replay, and while the robot is faulty."""
    if program.loop is not None:
        raise CommandError("this is a replay, which cannot be driven")
    latest = program.engine.latest.get()
    if latest is not None and latest.fault is not None:
        raise CommandError(f"the robot stands still until this is fixed: {latest.fault}")


def check_drawn(command: Command, program: Program) -> None:
    """Refuse to draw a map if the scans do not come from tape."""
    check_driving(command, program)
    if program.field.tape_width is None:
        raise CommandError(f"the field {program.field.name} is not of tape; maps are of tape")
