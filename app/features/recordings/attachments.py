"""The attachments that a replay needs besides messages: settings, map, robot, models, versions.

The names of the attachments are paths in one folder, so that references between the files work:

    settings.toml             all settings at the start of the recording
    map/square.svg            the map; or a ROS map: the YAML file and its picture
    robot/robot.urdf          the robot, and the lens file that it names
    models/my_model.py        the user's own models that were in use
    versions.json             versions of the program and its libraries
"""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

SETTINGS = "settings.toml"
URDF = "robot/robot.urdf"
PROFILE = "robot/profile.toml"
VERSIONS = "versions.json"

MEDIA_TYPES = {
    ".toml": "application/toml",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".yaml": "application/yaml",
    ".urdf": "application/xml",
    ".py": "text/x-python",
}


@dataclass(frozen=True, slots=True)
class Attachment:
    """A file within a recording."""

    name: str
    """A path in the folder of all attachments."""
    data: bytes = field(repr=False)

    @property
    def media_type(self) -> str:
        """The media type, by the suffix of the name."""
        return MEDIA_TYPES.get(Path(self.name).suffix.lower(), "application/octet-stream")


@dataclass(frozen=True, slots=True)
class Contents:
    """The facts and files at the beginning of a recording."""

    facts: dict[str, str]
    """The most important facts, by name."""
    attachments: tuple[Attachment, ...] = ()


def as_toml(group: Any) -> str:
    """Write a tree of settings dataclasses as TOML; ``load_config`` reads the same tree from it."""
    values = _fields(group)
    tables: Mapping[str, Any] = values.pop("added", {})  # of features, beside the program's own
    return "\n".join(_lines({**values, **tables}, ())) + "\n"


def _lines(group: Any, path: tuple[str, ...]) -> Iterator[str]:
    values = group if isinstance(group, Mapping) else _fields(group)
    tables = {name: value for name, value in values.items() if _is_table(value)}
    if path:
        yield f"\n[{'.'.join(map(_key, path))}]"
    # A table's own values come before the tables in it.
    for name, value in values.items():
        if name not in tables:
            yield f"{_key(name)} = {_value(value)}"
    for name, table in tables.items():
        if table != {}:
            yield from _lines(table, (*path, name))


def _fields(group: Any) -> dict[str, Any]:
    return {field.name: getattr(group, field.name) for field in dataclasses.fields(group)}


def _is_table(value: Any) -> bool:
    return dataclasses.is_dataclass(value) or isinstance(value, Mapping)


def _key(name: str) -> str:
    return name if re.fullmatch("[A-Za-z0-9_-]+", name) else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, tuple | list):
        return f"[{', '.join(_value(item) for item in value)}]"
    if isinstance(value, Mapping):
        return (
            f"{{{', '.join(f'{_key(name)} = {_value(entry)}' for name, entry in value.items())}}}"
        )
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes like TOML, except for the last control character (DEL).
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return repr(value)
