"""Writes maps that were drawn by driving."""

from __future__ import annotations

from pathlib import Path

from app.files import atomic_file
from robot.fields.grid_map import save_map_yaml
from robot.fields.svg_field import field_of_drawing
from robot.mapping.seen_floor import with_unseen
from robot.mapping.tape_map import TapeMap

CELL = 0.005
"""Side of the ROS map's cells [m]."""


def written_for(out: Path) -> tuple[Path, ...]:
    """Return all files that a map has whose drawing is a file."""
    return out, out.with_suffix(".yaml"), out.with_suffix(".pgm")


def write_map(drawn: TapeMap, out: Path, title: str) -> None:
    """Write a drawing, and the ROS map of the same name beside it.

    In the ROS map, floor that nobody looked at is unknown.

    Raises:
        FieldError: the strokes are no field that a robot can be on.
        OSError: a file cannot be written.
    """
    text = drawn.drawing(title)
    field = field_of_drawing(text, out.stem)
    field.require_free()
    grid = with_unseen(field.occupancy(CELL), drawn.seen)
    out.parent.mkdir(parents=True, exist_ok=True)
    # The drawing last: on a full disk there is none, and its name is still free.
    save_map_yaml(grid, out.with_suffix(".yaml"))
    with atomic_file(out) as new:
        new.write_text(text, encoding="utf-8")
