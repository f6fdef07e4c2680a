"""Commands that change the faults of a simulated robot while it drives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from app.engine.command_row import CommandRow, TickContext
from app.engine.program import Program
from app.features.faults.messages import SetFaultsCommand
from app.settings.conditions import CONDITIONS
from app.settings.config import with_settings
from app.settings.faults import TABLES
from robot.errors import CommandError
from robot.settings import SettingError
from sim.simulated import SimSettings, SimulatedRobot


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


def with_faults(settings: SimSettings, values: Mapping[str, float | str]) -> SimSettings:
    """Return settings with other faults.

    A picture that is stamped later is delivered later, too: no stamp may lie in the future.

    Raises:
        SettingError: a name is unknown or a value out of range; the message says what is valid.
    """
    unknown = [name for name in values if name not in TABLES]
    if unknown:
        raise SettingError(f"there is no fault {unknown[0]}; valid are {', '.join(TABLES)}")
    result = with_settings(settings, {f"{TABLES[name]}.{name}": values[name] for name in values})
    later = result.camera.stamp_error - settings.camera.stamp_error
    delay = min(max(settings.camera.delay + later, 0.0), 1.0)
    return replace(result, camera=replace(result.camera, delay=delay))


def condition_faults(name: str) -> dict[str, Any]:
    """Return the faults of a named condition."""
    preset = {path.rpartition(".")[2]: value for path, value in CONDITIONS[name].items()}
    return {fault: value for fault, value in preset.items() if fault in TABLES}


COMMANDS = (CommandRow(SetFaultsCommand, _set_faults, check=_check_faults, slow=True),)
