"""The corners of a board that a picture shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.board import Board
from robot.errors import BrickPoseError
from robot.geometry import Array

Grey = NDArray[np.uint8]
"""(h, w)"""

LEAST_CORNERS = 8
"""Fewest corners of a board that is partly in sight: fewer hardly tell its pose."""
REFINE = cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4
"""When the search for the exact corner ends: after 100 steps, or one of less than 1e-4 px."""
SHARE = 0.3
"""Reach of the search for the exact corner, as a share of the distance to the next."""
REACH_PX = 2, 11
"""Its least and its greatest reach [px]."""


class SightingError(BrickPoseError, ValueError):
    """A picture shows no board that is of use; the message says why."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """The corners of a board that one picture shows."""

    ids: NDArray[np.intp]
    """(k,) which of the board's corners."""
    pixels: Array = field(repr=False)
    """(k, 2) where they are [px]."""
    size: tuple[int, int]
    """Width and height of the picture [px]."""
    edge_width: float = 0.0
    """How wide the edges between squares are [px], by the more blurred direction."""

    def mirrored(self, board: Board) -> Sighting:
        """Return what the picture would show if it were mirrored."""
        across = board.inner[0]
        row, column = np.divmod(self.ids, across)
        flipped = self.pixels * (-1, 1) + (self.size[0] - 1, 0)
        return Sighting(row * across + across - 1 - column, flipped, self.size, self.edge_width)

    @cached_property
    def places(self) -> dict[int, Array]:
        """Where each corner is, by its number."""
        return dict(zip(self.ids.tolist(), self.pixels, strict=True))


def pairs(seen: Sighting, board: Board, step: int) -> Iterator[tuple[Array, Array]]:
    """Yield the places of neighbouring corners; a step of 1 is along a row."""
    across = board.inner[0]
    for number, place in seen.places.items():
        if step == 1 and (number + 1) % across == 0:
            continue
        other = seen.places.get(number + step)
        if other is not None:
            yield place, other


def tones(picture: Grey, points: Array) -> Array:
    """Return the brightness at points (n, 2)."""
    if not len(points):
        return np.empty(0)
    x, y = points.T.astype(np.float32)
    return np.asarray(cv2.remap(picture, x, y, cv2.INTER_LINEAR), np.float64).ravel()
