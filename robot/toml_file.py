"""Reads TOML, which may come from anywhere: from a user's file, or from within a recording."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from robot.settings import SettingError

LONGEST = 1_000_000
"""Longest text [characters]: reading TOML takes seconds for each megabyte."""

DEEPEST = 20
"""Most tables and lists within each other, and most parts of a key; settings need five."""

_PART = r"""(?:[\w-]++|"(?:[^"\\\n]|\\.)*+"|'[^'\n]*+')"""
_LONG_KEY = re.compile(
    rf"(?:^|[{{,\[])[ \t]*+{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{DEEPEST}}}", re.MULTILINE
)
"""A key of too many parts. Nothing in it is tried in two ways, so the search takes linear time."""


def read_toml_text(path: Path) -> str:
    """Return the text of a file.

    Raises:
        SettingError: the file cannot be read, or is no text.
    """
    try:
        return path.read_text(encoding="utf-8-sig")  # some editors on Windows begin with a mark
    except OSError as error:
        raise SettingError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise SettingError(f"{path} is no text in UTF-8: save it as UTF-8 ({error})") from error


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """Return the tables of a TOML text; ``source`` is its name for messages.

    Raises:
        SettingError: it is not TOML, too long, or its tables are nested too deeply.
    """
    if len(text) > LONGEST:
        raise SettingError(f"{source} is too long; valid are up to {LONGEST} characters")
    if key := _LONG_KEY.search(text):
        line = text.count("\n", 0, key.start()) + 1
        raise SettingError(
            f"{source} has a key of more than {DEEPEST} parts in line {line}; valid are up to "
            f"{DEEPEST}, as in a.b.c = 1"
        )
    too_deep = f"{source} is nested too deeply; valid are up to {DEEPEST} tables in each other"
    try:
        result = tomllib.loads(text)
    except RecursionError as error:
        raise SettingError(too_deep) from error
    except ValueError as error:  # also a number of thousands of digits
        raise SettingError(f"{source} is no TOML: {error}") from error
    if _depth(result) > DEEPEST:
        raise SettingError(too_deep)
    return result


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file.

    Raises:
        SettingError: the file cannot be read or is not TOML.
    """
    return parse_toml(read_toml_text(path), str(path))


def _depth(table: dict[str, Any]) -> int:
    """Return how many tables and lists lie within each other; recursion would have a limit."""
    depth = 0
    level: list[dict[str, Any] | list[Any]] = [table]
    while level:
        depth += 1
        inside = (item.values() if isinstance(item, dict) else item for item in level)
        level = [inner for items in inside for inner in items if isinstance(inner, dict | list)]
    return depth
