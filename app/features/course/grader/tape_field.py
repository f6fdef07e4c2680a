"""A small field of tape, and the distance of each of its cells from the nearest edge."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

CELL = 0.02
ORIGIN = np.array([-0.6, -0.4])
"""The lower left corner of the first cell [m]."""
ROWS, COLUMNS = 110, 120
TAPE = np.array([[0.3, 0.3, 1.1, 0.3], [1.1, 0.3, 1.1, 1.0], [1.1, 1.0, 0.5, 0.9]])
"""Edges of tape, x0, y0, x1, y1 [m]: no two directions look alike."""


def tape_field() -> SimpleNamespace:
    """Return distances (rows, columns) [m], the first cell's corner, and a cell's side [m]."""
    rows, columns = np.mgrid[:ROWS, :COLUMNS]
    middles = np.stack([ORIGIN[0] + (columns + 0.5) * CELL, ORIGIN[1] + (rows + 0.5) * CELL], -1)
    nearest = np.full((ROWS, COLUMNS), np.inf)
    for x0, y0, x1, y1 in TAPE:
        start, along = np.array([x0, y0]), np.array([x1 - x0, y1 - y0])
        share = np.clip((middles - start) @ along / (along @ along), 0.0, 1.0)
        away = np.linalg.norm(middles - start - share[..., None] * along, axis=-1)
        nearest = np.minimum(nearest, away)
    return SimpleNamespace(distances=nearest, origin=ORIGIN.copy(), cell=CELL)
