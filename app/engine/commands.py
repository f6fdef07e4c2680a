"""The one table of commands: its rows stand with what carries them out."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from functools import cache, reduce
from typing import Annotated, Any

from pydantic import Field, TypeAdapter, ValidationError

from app.engine.command_row import CommandRow, TickContext, type_of
from app.engine.controls import Controls
from app.engine.plugging import plugged
from app.engine.program import Program
from app.languages.marking import phrase
from app.messages.commands import LONGEST_COMMAND, Command, in_words
from robot.driving.odometry import OdometryState
from robot.errors import CommandError, one_line

LONGEST_NAME = 60
"""Of a command that there is not, in messages [characters]."""

MOST_WAITING = 1000
"""Most commands that may wait: if the engine hangs, a flood of them must not fill the memory."""


def table() -> Mapping[type[Command], CommandRow]:
    """Return all rows by the type of their command, ours first."""
    return plugged().rows


def adapter() -> TypeAdapter[Any]:
    """Return what reads any command of the table from JSON."""
    return _adapter_of(tuple(table()))


@cache
def _adapter_of(types: tuple[type[Command], ...]) -> TypeAdapter[Any]:
    union: Any = reduce(operator.or_, types)
    return TypeAdapter(Annotated[union, Field(discriminator="type")])


def parse(text: str) -> Command:
    """Return the command in a JSON text.

    Raises:
        CommandError: the text is not a command; the message says what is wrong and what is valid.
    """
    if len(text) > LONGEST_COMMAND:
        raise CommandError(
            f"a command has at most {LONGEST_COMMAND} characters; this has {len(text)}"
        )
    try:
        command: Command = adapter().validate_json(text)
    except ValidationError as error:
        raise CommandError(refusal_of(error)) from error
    return command


def refusal_of(error: ValidationError) -> str:
    """Return why JSON is no command of this program, in words."""
    first = error.errors(include_url=False, include_input=False)[0]
    if first["type"] == "union_tag_invalid":  # pydantic's word for a command that there is not
        name = one_line(str(first["ctx"]["tag"]))[:LONGEST_NAME]
        valid = ", ".join(sorted(type_of(each) for each in table()))
        return phrase(f"no feature here has the command {name!r}; valid are {valid}")
    named = (each for each in table() if (type_of(each),) == first["loc"][:-1])
    return in_words(error, next((each.model_fields for each in named), ()))


def row_of(command: Command) -> CommandRow:
    """Return the row of a command.

    Raises:
        CommandError: the feature that has it does not take part.
    """
    row = table().get(type(command))
    if row is None:
        name = type_of(type(command))
        raise CommandError(f"nothing here carries out {name}: a feature was left out")
    return row


def check(command: Command, program: Program) -> None:
    """Refuse a command that this field, this robot or these parameters do not allow.

    A command is also refused if the engine has failed or too many commands wait; but from a replay
    that has failed there is a way back to the robot.

    Raises:
        CommandError: the command is refused; the message says why.
    """
    engine, row = program.engine, row_of(command)
    if engine.failure is not None and not row.after_failure:
        raise CommandError(engine.failure)
    if len(engine.commands) >= MOST_WAITING and not row.urgent:
        raise CommandError(f"{MOST_WAITING} commands wait already; send fewer, or wait for answers")
    row.allowed(program)
    row.check(command, program)
    row.check_field(command, program.field)


def apply(command: Command, controls: Controls, odometry: OdometryState) -> None:
    """Carry out a checked command in the engine."""
    row_of(command).apply(TickContext(command, controls, odometry))
