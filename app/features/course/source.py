"""Reads a student's file."""

from __future__ import annotations

import codecs
from pathlib import Path

from robot.settings import SettingError

LONGEST = 200_000
"""Longer files are refused [bytes]: no lesson needs a tenth of it."""
WIDE = {codecs.BOM_UTF16_LE: "utf-16-le", codecs.BOM_UTF16_BE: "utf-16-be"}
"""Marks of the encoding that Windows calls Unicode, and PowerShell's ``>`` writes."""


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
    # What is no UTF-8 becomes a sign that Python refuses, with its line. Some editors on Windows
    # begin a file with a mark, which is no part of it.
    wide = WIDE.get(content[:2])
    text = (
        content[2:].decode(wide, errors="replace")
        if wide
        else content.decode("utf-8-sig", errors="replace")
    )
    if "\0" in text:
        kind = "an archive; unpack it" if content.startswith(b"PK") else "no text"
        raise SettingError(f"{path} is {kind}; valid is Python code, saved as UTF-8")
    return text
