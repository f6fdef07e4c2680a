"""Lamps above a floor: uneven light, and reflections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from robot.fields.floor_picture import FloorPicture

REFLECTIONS = 4
REFLECTION_SD = 0.06
"""Size of a lamp's reflection on the floor: standard deviation of its brightness [m]."""


def add_uneven_light(floor: FloorPicture, lost: float, rng: np.random.Generator) -> FloorPicture:
    """Return a floor that is lit by one lamp above it.

    The loss of light grows with the square of the distance from the point below the lamp.

    Args:
        floor: the drawing of the floor; it is not changed.
        lost: share of the light that is lost at the farthest corner.
        rng: draws the position of the lamp.
    """
    if lost == 0:
        return floor
    height, width = floor.image.shape
    column, row = rng.uniform(0.1, 0.9, 2) * (width, height)
    x, y = np.arange(width) - column, np.arange(height)[:, None] - row
    distance2 = (x * x + y * y) / (max(column, width - column) ** 2 + max(row, height - row) ** 2)
    light = (1 - lost * distance2).astype(np.float32)
    return replace(floor, image=np.rint(floor.image * light).astype(np.uint8))


def add_glare(floor: FloorPicture, added: float, rng: np.random.Generator) -> FloorPicture:
    """Return a floor with reflections of lamps, on the tape as well.

    The reflections stay in place while the robot moves, as if the lamps were far above the camera.

    Args:
        floor: the drawing of the floor; it is not changed.
        added: grey levels that a reflection adds in its middle; the sum is limited to white.
        rng: draws the positions of the reflections.
    """
    if added == 0:
        return floor
    height, width = floor.image.shape
    glare = np.zeros((height, width), dtype=np.float32)
    sd = REFLECTION_SD / floor.resolution
    for column, row in rng.uniform(0.2, 0.8, (REFLECTIONS, 2)) * (width, height):
        across = np.exp(-0.5 * ((np.arange(width) - column) / sd) ** 2)
        down = np.exp(-0.5 * ((np.arange(height) - row) / sd) ** 2)
        glare += (added * down[:, None] * across).astype(np.float32)
    image = np.minimum(np.rint(floor.image + glare), 255).astype(np.uint8)
    return replace(floor, image=image)
