"""Carries out the steps of the filter by hand."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace

from app.engine.command_row import CommandRow, Repeat, TickContext
from app.engine.controls import Controls
from app.engine.localization import Localization
from app.engine.program import Program
from app.features.weighing.messages import (
    FilterByHandCommand,
    FilterStepCommand,
    FilterUndoCommand,
)
from app.languages.marking import phrase
from robot.errors import CommandError
from robot.localization.filter_by_hand import StepError

PARTICLES = "particles"
"""The filter that has steps."""


def _filter_by_hand(tick: TickContext[FilterByHandCommand]) -> None:
    localization = tick.localization
    with _refusals(tick.controls):
        if tick.command.on:
            _take_particles(localization)
        localization.by_hand.switch(localization.localizer if tick.command.on else None)


def _take_particles(localization: Localization) -> None:
    """Choose the particle filter, if it is another one, with the heaviest place of that."""
    parameters = localization.parameters
    if parameters.filter.filter == PARTICLES:
        return
    places = localization.localizer.filter.hypotheses
    chosen = replace(parameters.filter, filter=PARTICLES)
    localization.use(replace(parameters, filter=chosen))
    if len(places) > 1:
        heaviest = max(places, key=lambda place: place.weight)
        localization.localizer.set_hypotheses((heaviest,))


def _filter_step(tick: TickContext[FilterStepCommand]) -> None:
    """Take a step, if this is the time for it."""
    localization, step = tick.localization, tick.command.step
    with _refusals(tick.controls):
        belief = localization.by_hand.step(
            step, localization.newest, localization.parts, localization.unchanging
        )
        if step == "weigh":
            localization.note_update()
            localization.belief = belief or localization.belief


def _filter_undo(tick: TickContext[FilterUndoCommand]) -> None:
    """Take back a step, if there is one."""
    localization = tick.localization
    with _refusals(tick.controls):
        localization.put_back(localization.by_hand.undo())


def require_particles(program: Program) -> None:
    """Refuse steps of a filter that is no particle filter.

    Whether it is the time for a step is only known when the commands before it are carried out.
    """
    latest = program.engine.latest.get()
    kind = (latest.filter.parameters if latest else program.config.localization).filter.filter
    if kind != PARTICLES:
        raise CommandError(f"the filter {kind} has no steps by hand; choose particles")


@contextlib.contextmanager
def _refusals(controls: Controls) -> Iterator[None]:
    """Note a step that cannot be taken now."""
    try:
        yield
    except StepError as error:
        words = phrase(f"A step by hand was not taken: {error}.")
        controls.problems.note(controls.stamp, words)


COMMANDS = (
    CommandRow(FilterByHandCommand, _filter_by_hand, Repeat.MOMENT),
    CommandRow(FilterStepCommand, _filter_step, Repeat.MOMENT, allowed=require_particles),
    CommandRow(FilterUndoCommand, _filter_undo, Repeat.MOMENT, allowed=require_particles),
)
