"""Changes what is wrong with a simulated robot, while it drives."""

from __future__ import annotations

from app.engine.controls import Controls
from app.engine.program import Program
from app.messages.commands import SetFaultsCommand
from app.settings.faults import ROBOT, with_faults
from robot.driving.odometry import OdometryState
from robot.errors import CommandError
from robot.settings import SettingError
from sim.simulated import SimulatedRobot


def set_faults(command: SetFaultsCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Change the faults of the robot."""
    robot = controls.robot
    assert isinstance(robot, SimulatedRobot)  # ``check_faults`` made sure of it
    robot.change(with_faults(robot.settings, command.values))


def check_faults(command: SetFaultsCommand, program: Program) -> None:
    """Refuse faults that this robot cannot have.

    Raises:
        CommandError: the robot is real or recorded, or a value is not valid.
    """
    robot = program.robot
    if not isinstance(robot, SimulatedRobot):
        raise CommandError(f"{robot.name} is real or recorded; faults are for simulated robots")
    perfect = [name for name in command.values if name in ROBOT and not robot.has_imperfections]
    if perfect:
        raise CommandError(f"{robot.name} has perfect wheels and mounting: no {perfect[0]}")
    try:
        with_faults(robot.settings, command.values)
    except SettingError as error:
        raise CommandError(str(error)) from error
