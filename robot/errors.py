"""Errors that the program reports to its users; any other exception is a defect of the program."""

from typing import ClassVar

LONGEST = 1500
"""Longest message [characters]; a list of the names of all settings fits in."""


class BrickPoseError(Exception):
    """Something that a user can put right; the message says what is wrong and what is valid.

    Each subclass derives from a standard exception too. The message is one line, even if it
    quotes a file or a request: unprintable characters are escaped, and a long text is cut.
    """

    exit_code: ClassVar[int] = 1
    """What a command ends with that fails so: 2 if what was typed is wrong."""

    def __str__(self) -> str:
        return one_line(super().__str__())


def one_line(text: str) -> str:
    """Return a text in one line of printable characters, at most ``LONGEST`` of them.

    Line ends and the space around them become one space. Messages quote what users and other
    programs wrote, and must be safe in a terminal, a log and a JSON answer.
    """
    lines = (line.strip() for line in text[: 10 * LONGEST].splitlines())
    joined = " ".join(line for line in lines if line)
    shown = "".join(char if char.isprintable() else repr(char)[1:-1] for char in joined)
    return shown if len(shown) <= LONGEST else f"{shown[: LONGEST - 4]} ..."


class CommandError(BrickPoseError, ValueError):
    """A command is invalid, or cannot be carried out now; the message says what is valid."""


class PackageError(BrickPoseError, ImportError):
    """An optional package is missing; the message says how to install it."""


class PortError(BrickPoseError, OSError):
    """A serial port, a network port or a socket cannot be used; the message says what to do."""
