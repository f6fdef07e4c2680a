"""Carries out the steps of the filter by hand."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

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
    localization = controls.localization
    with _refusals(controls):
        localization.by_hand.switch(localization.localizer if command.on else None)


def filter_step(command: FilterStepCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Take a step, if this is the time for it."""
    localization = controls.localization
    with _refusals(controls):
        belief = localization.by_hand.step(
            command.step, localization.newest, localization.parts, localization.unchanging
        )
        if command.step == "weigh":
            localization.own.note_update()
            localization.belief = belief or localization.belief


def filter_undo(_command: FilterUndoCommand, controls: Controls, _odometry: OdometryState) -> None:
    """Take back a step, if there is one."""
    localization = controls.localization
    with _refusals(controls):
        localization.put_back(localization.by_hand.undo())


def check_particles_filter(_command: HandCommand, program: Program) -> None:
    """Refuse steps of a filter that is no particle filter.

    Whether it is the time for a step is only known when the commands before it are carried out.
    """
    latest = program.engine.latest.get()
    kind = (latest.parameters if latest else program.config.localization).filter.filter
    if kind != "particles":
        raise CommandError(f"the filter {kind} has no steps by hand; choose particles")


@contextlib.contextmanager
def _refusals(controls: Controls) -> Iterator[None]:
    """Note a step that cannot be taken now."""
    try:
        yield
    except StepError as error:
        words = phrase(f"A step by hand was not taken: {error}.")
        controls.problems.note(controls.stamp, words)
