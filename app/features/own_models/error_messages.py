"""Error messages about a user's file, with the line."""

from __future__ import annotations

import contextlib
import inspect
import sys
import traceback
from collections.abc import Iterator
from pathlib import Path

from app.languages.marking import phrase
from robot.errors import BrickPoseError

MODULE_PREFIX = "own_model_"
"""Prefix of the name of each module that is made from a user's file."""

LONGEST = 300
"""Longer messages are cut to this length [characters]: the page shows them in one line."""


MOST_CALLS = 20
"""Longer traces, as of a function that calls itself, are cut to this number of calls."""


class OwnModelError(BrickPoseError, ValueError):
    """A user's own model cannot be used; the message names its file and, if known, the line."""

    trace = ""
    """The calls that led there, from the user's file on, with their lines."""


@contextlib.contextmanager
def errors_named_after(path: Path, line: int | None = None) -> Iterator[None]:
    """Turn an error in the block into a message about a file.

    Args:
        path: the user's file.
        line: the line to name if the traceback has no line of that file.

    Raises:
        OwnModelError: the block raised an error.
    """
    try:
        yield
    except (Exception, SystemExit) as error:
        result = _innermost_line(error, path)
        named = OwnModelError(place(path, result or line) + _words(error))
        named.trace = _trace(error, path)
        raise named from error


def place(path: Path, line: int | None) -> str:
    """Return the beginning of a message about a file: its name and line."""
    return f"{path.name} line {line}: " if line else f"{path.name}: "


def running(thread: int | None) -> str | None:
    """Return in words which line of a user's file a thread is running; None if it is in none.

    Args:
        thread: its ``ident``.
    """
    frame = sys._current_frames().get(thread) if thread is not None else None
    while frame is not None:
        if str(frame.f_globals.get("__name__", "")).startswith(MODULE_PREFIX):
            return place(Path(frame.f_code.co_filename), frame.f_lineno) + phrase(
                "this does not end."
            )
        frame = frame.f_back
    return None


def line_of(function: object, path: Path) -> int | None:
    """Return the line of a file where a function or method begins; None if it is not known."""
    inner = getattr(function, "py_func", function)  # the function that numba compiled
    code = getattr(inspect.unwrap(inner), "__code__", None) if callable(inner) else None
    known = code is not None and code.co_filename == str(path)
    return code.co_firstlineno if known and code is not None else None


def _innermost_line(error: BaseException, path: Path) -> int | None:
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return error.lineno
    lines = [
        frame.lineno
        for frame in traceback.extract_tb(error.__traceback__)
        if frame.filename == str(path)
    ]
    return lines[-1] if lines else None


def _trace(error: BaseException, path: Path) -> str:
    """Return the calls from the user's file on, the innermost last; empty if it has no part."""
    frames = traceback.extract_tb(error.__traceback__)
    first = next((i for i, frame in enumerate(frames) if frame.filename == str(path)), None)
    if first is None:
        return ""
    lines = [
        f"{Path(frame.filename).name} line {frame.lineno}, in {frame.name}\n    {frame.line}"
        for frame in frames[first:][:MOST_CALLS]
    ]
    return "\n".join([*lines, _words(error)])


def _words(error: BaseException) -> str:
    if isinstance(error, OwnModelError):
        return str(error)
    text = " ".join(traceback.format_exception_only(error)[-1].split())
    return text if len(text) <= LONGEST else text[:LONGEST] + " ..."
