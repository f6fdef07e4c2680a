"""Draws the floor's grid over a picture, so that one sees whether a mounting is right."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.sighting import Grey
from robot.camera import FloorView, Lens
from robot.geometry import Array

APART = 0.1
"""Distance of the grid's lines [m]."""
REACH = 1.0
"""How far ahead, and to either side, the grid reaches [m]."""
STEPS = 200
"""Points of a line: the lens bends it."""
GRID, AXIS = (115, 158, 0), (0, 94, 213)
"""Colours (BGR) of Okabe and Ito, which colour-blind people can distinguish."""


def draw_floor(grey: Grey, lens: Lens, robot_from_camera: Array) -> NDArray[np.uint8]:
    """Return the picture (h, w, 3) with a grid of 0.1 m on the floor.

    The line straight ahead of the robot is red, distances from its axle stand beside it.
    """
    view = FloorView(lens, robot_from_camera)
    result = np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8)
    marks = np.arange(0, REACH + APART / 2, APART)
    along = np.linspace(0, REACH, STEPS)
    for mark in marks:
        for side in {mark, -mark}:
            line = np.column_stack([along, np.full(STEPS, side)])
            _draw(result, view, line, AXIS if mark == 0 else GRID)
        across = np.column_stack([np.full(2 * STEPS, mark), np.linspace(-REACH, REACH, 2 * STEPS)])
        _draw(result, view, across, GRID)
        _label(result, view, float(mark))
    return result


def _draw(
    image: NDArray[np.uint8], view: FloorView, line: Array, colour: tuple[int, int, int]
) -> None:
    pixels = view.pixels(line)
    seen = view.inside(pixels, -20)
    for start in np.flatnonzero(seen[:-1] & seen[1:]):
        ends = np.rint(16 * pixels[start : start + 2]).astype(int)
        (x0, y0), (x1, y1) = ends.tolist()
        cv2.line(image, (x0, y0), (x1, y1), colour, 1, cv2.LINE_AA, shift=4)


def _label(image: NDArray[np.uint8], view: FloorView, mark: float) -> None:
    pixel = view.pixels(np.array([[mark, 0.0]]))
    if view.inside(pixel, 12)[0]:
        x, y = np.rint(pixel[0]).astype(int).tolist()
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(image, f"{mark:.1f} m", (x + 4, y - 3), font, 0.4, AXIS, 1, cv2.LINE_AA)
