"""The fields that the page can load, by name."""

from __future__ import annotations

from pathlib import Path

from app.settings.config import MAPS
from robot.errors import CommandError
from robot.fields.field_loading import field_names
from robot.fields.generator.generated import generated_seed


def loadable_fields(saved: Path) -> dict[str, str]:
    """Return the name for ``load_field`` of each field: of those at hand and the saved maps."""
    own = {path.stem: str(path) for path in sorted(saved.glob("*.svg"))}
    return {name: name for name in field_names(MAPS)} | own


def field_named(name: str, saved: Path) -> str:
    """Return the name for ``load_field`` of a field that somebody asks for.

    Raises:
        CommandError: there is none; a path of this computer is none either.
    """
    known = loadable_fields(saved)
    if name in known:
        return known[name]
    if generated_seed(name) is not None:
        return name
    raise CommandError(
        f"there is no field {name!r}; valid are {', '.join(known)} and generated- with a number"
    )
