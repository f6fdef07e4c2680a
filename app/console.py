"""Output of lines for people."""

from __future__ import annotations

import io
import sys

from app.languages.catalogue import spoken


def never_fail_to_print() -> None:
    """Print a question mark for what the terminal or file has no sign for, as for a Greek letter.

    Redirected output is in the computer's own encoding on Windows, which may have few.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def say(text: str) -> None:
    """Write a line to standard output at once, in the environment's language where it is known."""
    sys.stdout.write(spoken().translated(text) + "\n")
    sys.stdout.flush()
