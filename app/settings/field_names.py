"""The fields that the page can load, by name."""

from __future__ import annotations

from pathlib import Path

from app.settings.config import MAPS
from robot.errors import CommandError
from robot.fields.field_loading import field_names
from robot.fields.generator.names import generated_seed


def loadable_fields(saved: Path) -> dict[str, str]:
    """Return the names of all fields and saved maps, as ``load_field`` takes them."""
    own = {path.stem: str(path) for path in sorted(saved.glob("*.svg"))}
    return {name: name for name in field_names(MAPS)} | own


def field_named(name: str, saved: Path) -> str:
    """Return the name of a requested field, as ``load_field`` takes it.

    Raises:
        CommandError: there is no such field; a path of this computer is not a name.
    """
    known = loadable_fields(saved)
    if name in known:
        return known[name]
    if generated_seed(name) is not None:
        return name
    raise CommandError(
        f"there is no field {name!r}; valid are {', '.join(known)} and generated- with a number"
    )
