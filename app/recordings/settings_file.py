"""Writes all settings as the text of a configuration file."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from typing import Any


def as_toml(group: Any) -> str:
    """Write a tree of settings dataclasses as TOML; ``load_config`` reads the same tree from it."""
    return "\n".join(_lines(group, ())) + "\n"


def _lines(group: Any, path: tuple[str, ...]) -> Iterator[str]:
    values = {field.name: getattr(group, field.name) for field in dataclasses.fields(group)}
    tables = {name: value for name, value in values.items() if dataclasses.is_dataclass(value)}
    if path:
        yield f"\n[{'.'.join(path)}]"
    # A table's own values come before the tables in it.
    for name, value in values.items():
        if name not in tables:
            yield f"{name} = {_value(value)}"
    for name, table in tables.items():
        yield from _lines(table, (*path, name))


def _value(value: Any) -> str:
    if isinstance(value, tuple | list):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes like TOML, except for the last control character (DEL).
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
