"""Reads commands from JSON texts, and says what is wrong with an invalid text."""

from __future__ import annotations

from pydantic import ValidationError

from app.messages.commands import COMMAND, Command
from robot.errors import CommandError

LONGEST = 2_000_000
"""Longest command [characters]; 20,000 poses with weights are shorter."""


def parse(text: str) -> Command:
    """Return the command in a JSON text.

    Raises:
        CommandError: the text is not a command; the message says what is wrong and what is valid.
    """
    if len(text) > LONGEST:
        raise CommandError(f"a command has at most {LONGEST} characters; this has {len(text)}")
    try:
        return COMMAND.validate_json(text)
    except ValidationError as error:
        raise CommandError(in_words(error)) from error


def in_words(error: ValidationError) -> str:
    """Return the first mistake and where it is, in words."""
    first = error.errors(include_url=False, include_input=False)[0]
    path = ".".join(str(part) for part in first["loc"])
    return f"{path}: {first['msg']}" if path else first["msg"]
