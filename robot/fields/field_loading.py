"""Loads a field by its name or its file."""

from __future__ import annotations

from pathlib import Path

from robot.fields.field import Field, FieldError
from robot.fields.generator.generated import drawing, generated_seed
from robot.fields.grid_field import field_from_grid
from robot.fields.grid_map import MapError, load_map_yaml
from robot.fields.svg_field import field_of_drawing, load_svg

GENERATED = "generated-0 to generated-4294967295, or an .svg or .yaml file"


def load_field(name: str, maps: Path) -> Field:
    """Load a field by the name of a drawing in the folder ``maps``, or from an SVG or YAML file.

    A bare name (``square``) is a drawing of the folder; a name with an ending or a folder is a
    file. ``generated-17`` is the field that is generated from the seed 17, for any ``maps``. A ROS
    map's field has the name of its YAML file.

    Raises:
        FieldError: there is no such field (the message lists the available names), or its file
            cannot be used.
    """
    seed = generated_seed(name)
    if seed is not None:
        return _usable(field_of_drawing(drawing(seed), name))
    path = Path(name)
    if name and path.name == name and not path.suffix:
        path = maps / f"{name}.svg"
        if not path.is_file():
            available = ", ".join(field_names(maps)) or f"none in {maps}"
            raise FieldError(f"there is no field {name!r}; valid are {available}, {GENERATED}")
    if path.suffix.lower() == ".svg":
        return _usable(load_svg(path))
    if path.suffix.lower() in (".yaml", ".yml"):
        return _load_ros_map(path)
    available = ", ".join(field_names(maps))
    raise FieldError(f"{name!r} is no field; valid are {available}, {GENERATED}")


def field_names(maps: Path) -> list[str]:
    """Return the names of the drawings in a folder, sorted."""
    return sorted(path.stem for path in maps.glob("*.svg"))


def _usable(field: Field) -> Field:
    field.require_free()
    return field


def _load_ros_map(path: Path) -> Field:
    try:
        return field_from_grid(load_map_yaml(path), path.stem)
    except MapError as error:
        raise FieldError(str(error)) from error
