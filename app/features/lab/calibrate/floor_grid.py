"""Draws the floor's grid over a picture, so that one sees whether a mounting is right."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.sighting import Grey
from robot.calibration.mounting.floor_grid import grid_labels, grid_lines
from robot.camera import FloorView, Lens
from robot.geometry import Array

GRID, AXIS = (115, 158, 0), (0, 94, 213)
"""Colours (BGR) of Okabe and Ito, which colour-blind people can distinguish."""


def draw_floor(grey: Grey, lens: Lens, robot_from_camera: Array) -> NDArray[np.uint8]:
    """Return the picture (h, w, 3) with a grid of 0.1 m on the floor.

    The line straight ahead of the robot is red, distances from its axle stand beside it.
    """
    view = FloorView(lens, robot_from_camera)
    result = np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR), np.uint8)
    for line in sorted(grid_lines(view), key=lambda line: line.ahead):
        points = np.rint(16 * line.pixels).astype(np.int32).reshape(-1, 1, 2)
        colour = AXIS if line.ahead else GRID
        cv2.polylines(result, [points], False, colour, 1, cv2.LINE_AA, shift=4)
    for mark, pixel in grid_labels(view):
        x, y = np.rint(pixel).astype(int).tolist()
        font = cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(result, f"{mark:.1f} m", (x + 4, y - 3), font, 0.4, AXIS, 1, cv2.LINE_AA)
    return result
