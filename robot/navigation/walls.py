"""Walls: what a robot must not touch besides shapes on the floor: tape or not, keep-out zones."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.fields.field import Field
from robot.navigation.settings import TAPE, NavigationSettings

Polygon = tuple[tuple[float, float], ...]
"""x, y [m] of each corner in the map; the last is joined to the first."""

NOTE = "data-tape-is"
"""The attribute of a drawing that says whether its tape is ``wall`` or ``ignored``."""
SHIFT = 8
"""Corners are rounded to a cell's side divided by 2 to this power."""


@dataclass(frozen=True)
class Walls:
    """What somebody has said of a field's walls, while the program runs."""

    tape: str | None = None
    """``wall`` or ``ignored``; None is as the field's drawing or the settings say."""
    zones: tuple[Polygon, ...] = ()
    """Keep-out zones."""
    stamp: float = 0.0
    """When it was said [s]."""

    def ignore_tape(self, field: Field, settings: NavigationSettings) -> bool:
        """Whether the robot may cross a field's tape."""
        return (self.tape or tape_of(field) or settings.tape) == "ignored"

    def cells(
        self, origin: tuple[float, float], side: float, shape: tuple[int, int]
    ) -> NDArray[np.bool_]:
        """Return which cells (h, w), row 0 at the bottom, are touched by a zone.

        Args:
            origin: lower left corner of the cells in the map [m].
            side: of a cell [m].
            shape: rows and columns.
        """
        touched = np.zeros(shape, np.uint8)
        for zone in self.zones:
            corners = (np.array(zone) - origin) / side - 0.5
            # OpenCV counts in 32 bits; what is far beyond the cells need not be exact.
            corners = np.clip(corners, -max(shape), 2 * max(shape))
            points = np.rint(corners * (1 << SHIFT)).astype(np.int32)
            # The line too, which closes gaps of a cell.
            cv2.fillPoly(touched, [points], 1, cv2.LINE_8, SHIFT)
        return touched > 0


def tape_of(field: Field) -> str | None:
    """Return what a field's drawing says of its tape; None if it says nothing valid."""
    said = field.notes.get(NOTE)
    return said if said in TAPE else None
