"""Printed boards: where their corners are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from robot.geometry import Array
from robot.settings import SettingError

KINDS = ("chessboard", "charuco")
LEAST, MOST = 3, 40
"""Fewest and most squares along a side."""
DICTIONARIES = {
    "4x4_50": cv2.aruco.DICT_4X4_50,
    "4x4_250": cv2.aruco.DICT_4X4_250,
    "5x5_100": cv2.aruco.DICT_5X5_100,
    "5x5_250": cv2.aruco.DICT_5X5_250,
    "6x6_250": cv2.aruco.DICT_6X6_250,
}
"""Marker dictionaries of OpenCV, by name."""


@dataclass(frozen=True)
class Board:
    """A chessboard, or one with markers in its white squares (ChArUco).

    Its frame lies on the paper: the origin is the lower right corner of the outermost square, x
    points up the page, y to its left, and z out of the paper. So a board that lies upright before
    a robot is turned as the robot is.
    """

    kind: str
    """chessboard or charuco."""
    columns: int
    """Squares across the page."""
    rows: int
    """Squares up the page."""
    square: float
    """Side of a square [m]."""
    marker: float = 0.7
    """Side of a marker, as a share of the square's (charuco)."""
    dictionary: str = "5x5_250"
    """Which markers (charuco)."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise SettingError(f"the board is {self.kind!r}; valid are {', '.join(KINDS)}")
        if not (LEAST <= self.columns <= MOST and LEAST <= self.rows <= MOST):
            raise SettingError(
                f"a board of {self.columns} x {self.rows} squares; valid is {LEAST} to {MOST} "
                "along each side"
            )
        if not 0.001 <= self.square <= 1:
            raise SettingError(f"squares of {self.square:g} m; valid is 0.001 to 1 m")
        if not 0.3 <= self.marker <= 0.95:
            raise SettingError(f"markers of {self.marker:g} of a square; valid is 0.3 to 0.95")
        if self.dictionary not in DICTIONARIES:
            raise SettingError(
                f"the markers are {self.dictionary!r}; valid are {', '.join(DICTIONARIES)}"
            )
        needed, known = self.columns * self.rows // 2, int(self.dictionary.split("_")[1])
        if self.kind == "charuco" and needed > known:
            raise SettingError(
                f"a board of {self.columns} x {self.rows} squares has {needed} markers, and there "
                f"are {known} of {self.dictionary}; valid are fewer squares, or others of "
                f"{', '.join(DICTIONARIES)}"
            )

    @property
    def inner(self) -> tuple[int, int]:
        """Inner corners across and up the page."""
        return self.columns - 1, self.rows - 1

    @property
    def words(self) -> str:
        """What it is, for people."""
        across, up = self.inner
        return (
            f"{self.kind} of {self.columns} x {self.rows} squares ({across} x {up} inner corners)"
        )

    @cached_property
    def corners(self) -> Array:
        """Inner corners (n, 3) [m], row by row from the upper left as OpenCV numbers them."""
        across, up = self.inner
        row, column = np.divmod(np.arange(across * up), across)
        x, y = self.rows - 1.0 - row, self.columns - 1.0 - column
        return np.column_stack([x, y, np.zeros(len(x))]) * self.square

    @cached_property
    def markers(self) -> cv2.aruco.CharucoBoard:
        """OpenCV's board of the same squares, with markers."""
        dictionary = cv2.aruco.getPredefinedDictionary(DICTIONARIES[self.dictionary])
        size = (self.columns, self.rows)
        return cv2.aruco.CharucoBoard(size, self.square, self.marker * self.square, dictionary)
