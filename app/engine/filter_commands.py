"""Commands that pause, update, reset and set the filter, and one that does nothing."""

from __future__ import annotations

from app.engine.command_row import CommandRow, Repeat, TickContext, nothing
from app.engine.parameter_changes import with_values_and_models
from app.engine.program import Program
from app.messages.commands import (
    PauseCommand,
    PingCommand,
    ResetCommand,
    ResumeCommand,
    SetParametersCommand,
    UpdateCommand,
)
from robot.errors import BrickPoseError, CommandError


def _pause(tick: TickContext[PauseCommand]) -> None:
    tick.localization.paused = True


def _resume(tick: TickContext[ResumeCommand]) -> None:
    tick.localization.paused = False


def _update(tick: TickContext[UpdateCommand]) -> None:
    tick.localization.update_once()


def _reset(tick: TickContext[ResetCommand]) -> None:
    tick.controls.reset()


def _set_parameters(tick: TickContext[SetParametersCommand]) -> None:
    tick.controls.set_parameters(tick.command.values)


def _check_parameters(command: SetParametersCommand, program: Program) -> None:
    latest = program.engine.latest.get()
    current = latest.filter.parameters if latest else program.config.localization
    try:
        choice = latest.filter.models if latest else program.given
        with_values_and_models(current, choice, command.values)
    except BrickPoseError as error:
        raise CommandError(str(error)) from error


COMMANDS = (
    CommandRow(PauseCommand, _pause, Repeat.MOMENT),
    CommandRow(ResumeCommand, _resume, Repeat.MOMENT),
    CommandRow(UpdateCommand, _update, Repeat.MOMENT),
    CommandRow(ResetCommand, _reset, Repeat.SETTING),
    CommandRow(SetParametersCommand, _set_parameters, Repeat.SETTING, check=_check_parameters),
    CommandRow(PingCommand, act=nothing, harmless=True, after_failure=True, urgent=True),
)
