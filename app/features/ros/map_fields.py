"""Fields that are read from ROS's map_server files."""

from __future__ import annotations

from pathlib import Path

from robot.fields.field import Field
from robot.hooks import FieldSource


def is_map_file(name: str) -> bool:
    """Return whether a name is that of a map's YAML."""
    return Path(name).suffix.lower() in (".yaml", ".yml")


def map_field(name: str) -> Field:
    """Return the field of a map's YAML."""
    from robot.fields.grid_field import load_ros_map  # noqa: PLC0415 - few fields are

    return load_ros_map(Path(name))


FIELDS = (FieldSource(".yaml", is_map_file, map_field, files=True),)
"""What ``load_field`` reads by these names."""
