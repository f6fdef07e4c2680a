"""Loads fields by name or file: drawings, and the fields that features add."""

from __future__ import annotations

from pathlib import Path

from robot.fields.field import Field, FieldError
from robot.fields.svg_field import load_svg
from robot.hooks import added


def load_field(name: str, maps: Path) -> Field:
    """Load a field by the name of a drawing in the folder ``maps``, from a file, or from a feature.

    A bare name (``square``) is a drawing of the folder; a name with an ending or a folder is a
    file. What is no drawing is asked of the features: ``generated-17`` is the field that is
    generated from the seed 17, for any ``maps``; a ROS map's field has the name of its YAML file.

    Raises:
        FieldError: there is no such field (the message lists the available names), or its file
            cannot be used.
    """
    path = Path(name)
    is_bare = bool(name) and path.name == name and not path.suffix
    if is_bare:
        path = maps / f"{name}.svg"
    if path.suffix.lower() == ".svg" and (not is_bare or path.is_file()):
        return _usable(load_svg(path))
    sources = added().fields
    for source in sources:
        if source.has(name):
            field: Field = source.make(name)
            return field
    words = [source.words for source in sources if not source.files]
    endings = " or ".join([".svg", *(source.words for source in sources if source.files)])
    known = field_names(maps) or ([f"none in {maps}"] if is_bare else [])
    valid = ", ".join([*known, *words, f"or an {endings} file{added().without}"])
    if is_bare:
        raise FieldError(f"there is no field {name!r}; valid are {valid}")
    raise FieldError(f"{name!r} is no field; valid are {valid}")


def field_names(maps: Path) -> list[str]:
    """Return the names of the drawings in a folder, sorted."""
    return sorted(path.stem for path in maps.glob("*.svg"))


def _usable(field: Field) -> Field:
    field.require_free()
    return field
