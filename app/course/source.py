"""Reads a student's file."""

from __future__ import annotations

from pathlib import Path

from robot.settings import SettingError

LONGEST = 200_000
"""Longer files are refused [bytes]: no lesson needs a tenth of it."""


def read_source(path: Path) -> str:
    """Return a student's file.

    Raises:
        SettingError: it cannot be read as text.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise SettingError(f"{path} cannot be read: {error.strerror}") from error
    if len(content) > LONGEST:
        raise SettingError(f"{path} has {len(content)} bytes; valid are up to {LONGEST}")
    # What is no UTF-8 becomes a sign that Python refuses, with its line.
    return content.decode("utf-8", errors="replace")
