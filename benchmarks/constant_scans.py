"""Trials of a scanner's constant: pictures of tape that is straight, bent or dashed.

They are taken once, in little and in strong noise. In the figures, a return is false, and a tape
missed, as in ``brickpose bench scan``.
"""

from __future__ import annotations

import pickle
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.settings.config import MAPS
from benchmarks.scan import NOISES, Trial, score, trials
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.svg_field import field_of_drawing
from robot.interface import Frame
from robot.scanning.line_scanner import LineScanner, LineScannerSettings

PICTURES = 60
"""Of each field, in each noise."""
DASHED = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="1600mm" height="1600mm" '
    'viewBox="-800 -800 1600 1600" data-start="0 0 0"><title>Dashed</title>'
    '<rect x="-500" y="-500" width="1000" height="1000" fill="none" stroke="#202225" '
    'stroke-width="50" stroke-dasharray="100 60"/></svg>'
)


@dataclass(frozen=True, eq=False)
class SeenField:
    """A field, and pictures of it."""

    name: str
    field: Field
    pictures: list[Trial]


def recorded(kept: Path | None, seed: int = 0) -> list[SeenField]:
    """Return all pictures; from a file, or to it if it is not there yet."""
    if kept is not None and kept.exists():
        seen: list[SeenField] = pickle.loads(kept.read_bytes())  # our own, of a minute ago
        return seen
    view = RobotSpec.load().floor_view
    fields = {
        "straight": load_field("square", MAPS),
        "bent": load_field("generated-2", MAPS),
        "dashed": field_of_drawing(DASHED, "dashed"),
    }
    seen = [
        SeenField(
            name,
            field,
            [trial for noise in NOISES for trial in trials(view, field, noise, PICTURES, seed)],
        )
        for name, field in fields.items()
    ]
    if kept is not None:
        kept.write_bytes(pickle.dumps(seen))
    return seen


def few(seen: list[SeenField]) -> list[SeenField]:
    """Return all: they are few."""
    return seen


def tried(seen: list[SeenField], other_numbers: int) -> dict[str, Any]:
    """Scan all pictures; return figures by their names, and a number for each picture's ranges.

    Args:
        other_numbers: if not 0, the seed of other pictures.
    """
    view = RobotSpec.load().floor_view
    figures: dict[str, float] = {}
    each = []
    for floor in recorded(None, other_numbers) if other_numbers else seen:
        scanner = LineScanner(view, LineScannerSettings(), floor.field.tape)
        ranges = [scanner.scan(Frame(0.0, trial.picture)).scan.ranges for trial in floor.pictures]
        each += [zlib.crc32(some.tobytes()) for some in ranges]
        judged = score(0.0, ranges, floor.pictures)
        figures |= {
            f"{floor.name}: sd [mm]": judged.sd_mm,
            f"{floor.name}: missed [%]": judged.missed_percent,
            f"{floor.name}: false [%]": judged.false_percent,
        }
    return figures | {"each": each}
