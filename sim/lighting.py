"""One lamp over a floor: what lies farther from it is darker."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot.fields.floor_picture import FloorPicture


def lit_unevenly(floor: FloorPicture, lost: float, rng: np.random.Generator) -> FloorPicture:
    """A floor under a lamp that hangs somewhere over it.

    Light falls with the square of the distance from below the lamp.

    Args:
        floor: as it was drawn; it is not changed.
        lost: share of the light that is lost at the farthest corner.
        rng: decides where the lamp hangs.
    """
    if lost == 0:
        return floor
    height, width = floor.image.shape
    column, row = rng.uniform(0.1, 0.9, 2) * (width, height)
    x, y = np.arange(width) - column, np.arange(height)[:, None] - row
    distance2 = (x * x + y * y) / (max(column, width - column) ** 2 + max(row, height - row) ** 2)
    light = (1 - lost * distance2).astype(np.float32)
    return replace(floor, image=np.rint(floor.image * light).astype(np.uint8))
