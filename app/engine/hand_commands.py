"""Carries out the steps of the filter by hand."""

from __future__ import annotations

from app.engine.controls import Controls
from app.engine.program import Program
from app.languages.marking import phrase
from app.messages.hand_commands import (
    FilterByHandCommand,
    FilterStepCommand,
    FilterUndoCommand,
    HandCommand,
)
from robot.driving.odometry import OdometryState
from robot.errors import CommandError
from robot.localization.filter_by_hand import StepError


def filter_by_hand(
    command: FilterByHandCommand, controls: Controls, _odometry: OdometryState
) -> None:
    """Switch the filter by hand on or off."""
    try:
        controls.localization.set_by_hand(enabled=command.on)
    except StepError as error:
        _refuse(error, controls)


def filter_step(command: FilterStepCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Take a step, if this is the time for it."""
    try:
        controls.localization.step_by_hand(command.step)
    except StepError as error:
        _refuse(error, controls)


def filter_undo(_command: FilterUndoCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Take back a step, if there is one."""
    try:
        controls.localization.undo_by_hand()
    except StepError as error:
        _refuse(error, controls)


def check_particles_filter(_command: HandCommand, program: Program) -> None:
    """Refuse steps of a filter that is no particle filter.

    Whether it is the time for a step is only known when the commands before it are carried out.
    """
    latest = program.engine.latest.get()
    kind = (latest.parameters if latest else program.config.localization).filter.filter
    if kind != "particles":
        raise CommandError(f"the filter {kind} has no steps by hand; choose particles")


def _refuse(error: StepError, controls: Controls) -> None:
    controls.problems.note(controls.stamp, phrase(f"A step by hand was not taken: {error}."))
