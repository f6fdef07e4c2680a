"""Tells of each stroke whether its tape is lighter or darker than the floor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from robot.geometry import Array
from robot.mapping.ends import RaysOnFloor
from robot.mapping.strokes import Stroke
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
        away, _ = cKDTree(_along(stroke)).query(middles, distance_upper_bound=width / 2)
        own = light[np.isfinite(away)]
        lighter = bool(2 * own.sum() > len(own)) if len(own) else mostly
        strokes.append(replace(stroke, light=lighter))
    return replace(tidy, strokes=tuple(strokes))


def _along(stroke: Stroke) -> Array:
    steps = np.hypot(*np.diff(stroke.points, axis=0).T)
    walked = np.concatenate([[0.0], np.cumsum(steps)])
    places = np.linspace(0.0, walked[-1], 2 + round(walked[-1] / SPACING))
    return np.column_stack([np.interp(places, walked, axis) for axis in stroke.points.T])
