"""The fields that the page can load, by name."""

from __future__ import annotations

from pathlib import Path

from app.settings.config import MAPS
from robot.errors import CommandError
from robot.fields.field_loading import field_names
from robot.hooks import FieldSource, added


def listed_fields(saved: Path) -> list[str]:
    """Return the names of all fields and saved maps, and an example of those that are made."""
    made = (name for source in _by_name() for name in source.examples)
    return list(dict.fromkeys([*_loadable(saved), *made]))


def field_named(name: str, saved: Path) -> str:
    """Return the name of a requested field, as ``load_field`` takes it.

    Raises:
        CommandError: there is no such field; a path of this computer is not a name.
    """
    known = _loadable(saved)
    if name in known:
        return known[name]
    if any(source.has(name) for source in _by_name()):
        return name
    valid = ", ".join([*known, *(source.words for source in _by_name())])
    valid += added().without
    raise CommandError(f"there is no field {name!r}; valid are {valid}")


def _loadable(saved: Path) -> dict[str, str]:
    reads = any(source.has("map.yaml") for source in added().fields)
    maps = sorted(saved.glob("*.yaml")) if reads else []
    own = {path.stem: str(path) for path in (*maps, *sorted(saved.glob("*.svg")))}
    return {name: name for name in field_names(MAPS)} | own


def _by_name() -> list[FieldSource]:
    return [source for source in added().fields if not source.files]
