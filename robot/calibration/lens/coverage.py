"""What pictures of a board still lack: parts of the picture, tilts, distances.

It needs no lens: a guess of one tells a board's tilt well enough. So a program that takes pictures
can guide with it from the first one on.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.board import Board
from robot.calibration.lens.sighting import Sighting
from robot.geometry import Array

COLUMNS, ROWS = 4, 3
"""Parts of the picture."""
NAMES = (
    ("upper left corner", "upper left", "upper right", "upper right corner"),
    ("left", "middle left", "middle right", "right"),
    ("lower left corner", "lower left", "lower right", "lower right corner"),
)
LEAST_CORNERS = 3
"""So many corners in a part are enough."""
TILT = math.radians(20)
"""A board counts as tilted from here on [rad]."""
TILTS = ("left", "right", "upper", "lower")
"""Sides of the board, as the picture shows it, that can be the far one."""
NEAR, FAR = 0.35, 0.20
"""A board that covers more of the picture than the first share is near, less than the second
far."""


def parts_seen(seen: Sequence[Sighting]) -> NDArray[np.intp]:
    """Return how many corners were seen in each part (rows, columns) of the picture."""
    count = np.zeros((ROWS, COLUMNS), np.intp)
    for sighting in seen:
        width, height = sighting.size
        columns = np.clip(sighting.pixels[:, 0] * COLUMNS / width, 0, COLUMNS - 1).astype(int)
        rows = np.clip(sighting.pixels[:, 1] * ROWS / height, 0, ROWS - 1).astype(int)
        np.add.at(count, (rows, columns), 1)
    return count


def tilt(sighting: Sighting, board: Board) -> tuple[float, str]:
    """Return how far a board is tilted [rad], and which side of it in the picture is far.

    The focal length is taken for the picture's width, which is near enough for this.
    """
    width, height = sighting.size
    flat = (sighting.pixels - ((width - 1) / 2, (height - 1) / 2)) / width
    _, turns, _, _ = cv2.solvePnPGeneric(
        board.corners[sighting.ids], flat, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    normal: Array = np.asarray(cv2.Rodrigues(np.asarray(turns[0]))[0], np.float64)[:, 2]
    # A board that faces the camera has its normal along -z; one that faces to the right, too, has
    # its right side farther away.
    angle = math.acos(float(np.clip(-normal[2], -1, 1)))
    if abs(normal[0]) > abs(normal[1]):
        return angle, "right" if normal[0] > 0 else "left"
    return angle, "lower" if normal[1] > 0 else "upper"


def missing(seen: Sequence[Sighting], board: Board) -> list[str]:
    """Return what is still missing, in words, the most important first; empty if nothing is."""
    words = []
    count = parts_seen(seen)
    bare = [NAMES[row][column] for row, column in np.argwhere(count < LEAST_CORNERS)]
    if bare:
        words.append(f"no board yet in the picture's {_listed(bare)}")
    tilted = [side for angle, side in (tilt(sighting, board) for sighting in seen) if angle > TILT]
    flat = [side for side in TILTS if side not in tilted]
    if flat:
        words.append(f"no board tilted by 20 degrees or more with its {_listed(flat)} side far")
    shares = [_share(sighting) for sighting in seen]
    if not any(share > NEAR for share in shares):
        words.append("no board near the camera, filling half of the picture")
    if not any(share < FAR for share in shares):
        words.append("no board farther away")
    return words


def _share(sighting: Sighting) -> float:
    """Return the share of the picture that the corners cover."""
    hull = cv2.convexHull(sighting.pixels.astype(np.float32))
    return cv2.contourArea(hull) / (sighting.size[0] * sighting.size[1])


def _listed(names: Sequence[str]) -> str:
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
