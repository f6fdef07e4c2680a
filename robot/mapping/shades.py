"""Tells of each stroke whether its tape is lighter or darker than the floor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from robot.mapping.ends import RaysOnFloor
from robot.mapping.tidying import TidyStrokes

SPACING = 0.01
"""Distance of the points along strokes to which rays belong [m]: less than half of most tape."""


def shaded(tidy: TidyStrokes, width: float, rays: RaysOnFloor) -> TidyStrokes:
    """Return strokes of tape of a width [m] with their shades, as most rays across each saw it.

    One that no ray crossed, because it was seen along its length, has the shade of most tape.
    """
    middles = (rays.entry + rays.leaving) / 2
    seen = np.isfinite(middles).all(axis=1)
    middles, light = middles[seen], rays.light[seen]
    mostly = bool(2 * light.sum() > len(light))
    strokes = []
    for stroke in tidy.strokes:
        away, _ = cKDTree(stroke.sampled(SPACING)).query(middles, distance_upper_bound=width / 2)
        own = light[np.isfinite(away)]
        lighter = bool(2 * own.sum() > len(own)) if len(own) else mostly
        strokes.append(replace(stroke, light=lighter))
    return replace(tidy, strokes=tuple(strokes))
