"""What pictures of a board still lack: parts of the picture, tilts, distances.

It needs no lens: a guess of one tells a board's tilt well enough. So a program that takes pictures
can guide with it from the first one on.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.board import Board
from robot.calibration.lens.sighting import Sighting
from robot.geometry import Array

COLUMNS, ROWS = 4, 3
"""Parts of the picture."""
NAMES = (
    ("upper left corner", "upper left part", "upper right part", "upper right corner"),
    ("left part", "middle left part", "middle right part", "right part"),
    ("lower left corner", "lower left part", "lower right part", "lower right corner"),
)
LEAST_CORNERS = 3
"""How many corners in a part are enough."""
TILT = math.radians(20)
"""A board counts as tilted from here on [rad]."""
TILTS = {
    "left": ("the left side", "tilt its right edge toward the camera"),
    "right": ("the right side", "tilt its left edge toward the camera"),
    "upper": ("the upper side", "tilt its lower edge toward the camera"),
    "lower": ("the lower side", "tilt its upper edge toward the camera"),
}
"""Sides of the board, as the picture shows it, that can be the far one; and what makes them so."""
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


def bare_corners(seen: Sequence[Sighting]) -> list[str]:
    """Return the names of the picture's corners in which too few corners of boards were seen."""
    few = parts_seen(seen) < LEAST_CORNERS
    names = (NAMES[row][column] for row, column in np.argwhere(few))
    return [name for name in names if name.endswith("corner")]


def normal(sighting: Sighting, board: Board) -> Array:
    """Return the direction (3,) out of the board's paper, in the camera's frame.

    A board that faces the camera has it along -z; one that faces to the right, too, has its right
    side farther away. The focal length is taken for the picture's width, which is near enough.
    """
    width, height = sighting.size
    flat = (sighting.pixels - ((width - 1) / 2, (height - 1) / 2)) / width
    _, turns, _, _ = cv2.solvePnPGeneric(
        board.corners[sighting.ids], flat, np.eye(3), None, flags=cv2.SOLVEPNP_IPPE
    )
    out: Array = np.asarray(cv2.Rodrigues(np.asarray(turns[0]))[0], np.float64)[:, 2]
    return out


def tilt(sighting: Sighting, board: Board) -> tuple[float, str]:
    """Return how far a board is tilted [rad], and which side of it in the picture is far."""
    x, y, z = normal(sighting, board).tolist()
    angle = math.acos(float(np.clip(-z, -1, 1)))
    if abs(x) > abs(y):
        return angle, "right" if x > 0 else "left"
    return angle, "lower" if y > 0 else "upper"


def share(sighting: Sighting) -> float:
    """Return the share of the picture that the corners cover."""
    hull = cv2.convexHull(sighting.pixels.astype(np.float32))
    return cv2.contourArea(hull) / (sighting.size[0] * sighting.size[1])


@dataclass(frozen=True, eq=False)
class Coverage:
    """What pictures of a board cover."""

    parts: NDArray[np.bool_] = field(repr=False)
    """(rows, columns) whether enough corners were seen in each part of the picture."""
    tilts: Mapping[str, float]
    """How far the board was tilted with each of its sides far [rad]."""
    nearest: float
    """The greatest share of the picture that a board covered."""
    farthest: float
    """The least; 1 without a picture."""

    @classmethod
    def of(cls, seen: Sequence[Sighting], board: Board) -> Coverage:
        """Return what the pictures cover."""
        tilts = dict.fromkeys(TILTS, 0.0)
        for sighting in seen:
            angle, side = tilt(sighting, board)
            tilts[side] = max(tilts[side], angle)
        shares = [share(sighting) for sighting in seen]
        parts = parts_seen(seen) >= LEAST_CORNERS
        return cls(parts, tilts, max(shares, default=0.0), min(shares, default=1.0))

    @property
    def bars(self) -> dict[str, float]:
        """How much there is of each kind, 0 to 1; all are 1 when nothing is missing.

        x counts the parts at the left and right side, y those above and below, and both the parts
        in the middle.
        """
        across, up = np.ones_like(self.parts), np.ones_like(self.parts)
        across[[0, -1], 1:-1] = up[1:-1, [0, -1]] = False
        near, far = self.nearest / NEAR, (1 - self.farthest) / (1 - FAR)
        tilts = [min(1.0, angle / TILT) for angle in self.tilts.values()]
        return {
            "x": float(self.parts[across].mean()),
            "y": float(self.parts[up].mean()),
            "size": (min(1.0, near) + min(1.0, far)) / 2,
            "tilt": sum(tilts) / len(tilts),
        }

    @property
    def missing(self) -> list[str]:
        """What is still missing, in words, the most important first; empty if nothing is."""
        words = []
        if self._bare:
            words.append(f"no board yet in parts of the picture: {', '.join(self._bare)}")
        if self._flat:
            sides = ", ".join(TILTS[side][0] for side in self._flat)
            words.append(f"no board tilted by 20 degrees or more, with this side far: {sides}")
        if self.nearest < NEAR:
            words.append("no board near the camera, filling half of the picture")
        if self.farthest > FAR:
            words.append("no board farther away")
        return words

    @property
    def next_steps(self) -> list[str]:
        """What to do next with the board, the most useful first; empty if nothing is missing."""
        steps = []
        if self._bare:
            place = min(self._bare, key=lambda name: not name.endswith("corner"))
            steps.append(f"hold it nearer to the picture's {place}")
        if self._flat:
            steps.append(TILTS[self._flat[0]][1])
        if self.nearest < NEAR:
            steps.append("bring it nearer, until it fills half of the picture")
        elif self.farthest > FAR:
            steps.append("hold it farther away")
        return steps

    @property
    def _bare(self) -> list[str]:
        return [NAMES[row][column] for row, column in np.argwhere(~self.parts)]

    @property
    def _flat(self) -> list[str]:
        return [side for side, angle in self.tilts.items() if angle < TILT]


def missing(seen: Sequence[Sighting], board: Board) -> list[str]:
    """Return what is still missing, in words, the most important first; empty if nothing is."""
    return Coverage.of(seen, board).missing
