"""Commands that change the faults of a simulated robot while it drives."""

from __future__ import annotations

from app.engine.command_row import CommandRow, TickContext
from app.engine.program import Program
from app.messages.commands import SetFaultsCommand
from app.settings.faults import with_faults
from robot.errors import CommandError
from robot.settings import SettingError
from sim.simulated import SimulatedRobot


def _set_faults(tick: TickContext[SetFaultsCommand]) -> None:
    robot = tick.controls.robot
    assert isinstance(robot, SimulatedRobot)  # ``_check_faults`` made sure of it
    robot.change(with_faults(robot.settings, tick.command.values))


def _check_faults(command: SetFaultsCommand, program: Program) -> None:
    """Refuse faults that this robot cannot have.

    Raises:
        CommandError: it has none, as real and recorded robots, or a value is not valid.
    """
    robot = program.facts
    if not robot.has_faults:
        raise CommandError(f"{robot.name} has no faults to set; the robots sim and kinematic have")
    try:
        with_faults(program.faults, command.values)
    except SettingError as error:
        raise CommandError(str(error)) from error


COMMANDS = (CommandRow(SetFaultsCommand, _set_faults, check=_check_faults, slow=True),)
