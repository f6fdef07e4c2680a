"""Printed boards: where their corners are."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array
from robot.settings import SettingError

KINDS = ("chessboard", "charuco", "aprilgrid")
LEAST, MOST = 3, 40
"""Fewest and most squares along a side."""
LEAST_TAGS, MOST_TAGS = 2, 24
"""Fewest and most tags along a side: 24 x 24 of apriltag_36h11 are nearly all that there are."""
DICTIONARIES: dict[str, int] = {
    **{
        f"{side}x{side}_{count}": getattr(cv2.aruco, f"DICT_{side}X{side}_{count}")
        for side in (4, 5, 6, 7)
        for count in (50, 100, 250, 1000)
    },
    "original": cv2.aruco.DICT_ARUCO_ORIGINAL,
    "apriltag_16h5": cv2.aruco.DICT_APRILTAG_16H5,
    "apriltag_25h9": cv2.aruco.DICT_APRILTAG_25H9,
    "apriltag_36h10": cv2.aruco.DICT_APRILTAG_36H10,
    "apriltag_36h11": cv2.aruco.DICT_APRILTAG_36H11,
}
"""Marker dictionaries of OpenCV, by name."""


def dictionary_of(name: str) -> cv2.aruco.Dictionary:
    """Return a dictionary of markers by its name."""
    return cv2.aruco.getPredefinedDictionary(DICTIONARIES[name])


@dataclass(frozen=True)
class Board:
    """A chessboard, one with markers in its white squares (ChArUco), or a grid of AprilTags.

    Its frame lies on the paper: the origin is the lower right corner of the outermost square, x
    points up the page, y to its left, and z out of the paper. So a board that lies upright before
    a robot is turned as the robot is.
    """

    kind: str
    """chessboard, charuco or aprilgrid."""
    columns: int
    """Squares, or tags, across the page."""
    rows: int
    """Squares, or tags, up the page."""
    square: float
    """Side of a square, or of a tag [m]."""
    marker: float = 0.7
    """Side of a marker, as a share of the square's (charuco)."""
    dictionary: str = "5x5_250"
    """Which markers (charuco, aprilgrid)."""
    spacing: float = 0.3
    """Gap between tags, as a share of a tag's side: Kalibr's tagSpacing (aprilgrid)."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise SettingError(f"the board is {self.kind!r}; valid are {', '.join(KINDS)}")
        if self.kind == "aprilgrid":
            self._check_tags()
        elif not (LEAST <= self.columns <= MOST and LEAST <= self.rows <= MOST):
            raise SettingError(
                f"a board of {self.columns} x {self.rows} squares; valid is {LEAST} to {MOST} "
                "along each side"
            )
        if not 0.001 <= self.square <= 1:
            meant = self.square / 1000
            cure = f" ({self.square:g} mm are {meant:g} m)" if 0.001 <= meant <= 1 else ""
            raise SettingError(f"squares of {self.square:g} m; valid is 0.001 to 1 m{cure}")
        if not 0.3 <= self.marker <= 0.95:
            raise SettingError(f"markers of {self.marker:g} of a square; valid is 0.3 to 0.95")
        if self.dictionary not in DICTIONARIES:
            raise SettingError(
                f"the markers are {self.dictionary!r}; valid are {', '.join(DICTIONARIES)}"
            )
        needed, known = self.columns * self.rows // 2, len(dictionary_of(self.dictionary).bytesList)
        if self.kind == "charuco" and needed > known:
            raise SettingError(
                f"a board of {self.columns} x {self.rows} squares has {needed} markers, and there "
                f"are {known} of {self.dictionary}; valid are fewer squares, or others of "
                f"{', '.join(DICTIONARIES)}"
            )

    def _check_tags(self) -> None:
        if not (LEAST_TAGS <= self.columns <= MOST_TAGS and LEAST_TAGS <= self.rows <= MOST_TAGS):
            raise SettingError(
                f"a grid of {self.columns} x {self.rows} tags; valid is {LEAST_TAGS} to "
                f"{MOST_TAGS} along each side"
            )
        if not 0.05 <= self.spacing <= 2:
            raise SettingError(f"gaps of {self.spacing:g} of a tag; valid is 0.05 to 2")

    @property
    def inner(self) -> tuple[int, int]:
        """Inner corners across and up the page; of tags all corners."""
        if self.kind == "aprilgrid":
            return 2 * self.columns, 2 * self.rows
        return self.columns - 1, self.rows - 1

    @property
    def words(self) -> str:
        """What it is, for people."""
        across, up = self.inner
        if self.kind == "aprilgrid":
            return f"aprilgrid of {self.columns} x {self.rows} tags"
        return (
            f"{self.kind} of {self.columns} x {self.rows} squares ({across} x {up} inner corners)"
        )

    @cached_property
    def corners(self) -> Array:
        """Inner corners (n, 3) [m], row by row from the upper left as OpenCV numbers them."""
        across, up = self.inner
        row, column = np.divmod(np.arange(across * up), across)
        if self.kind == "aprilgrid":
            x, y = (self._along(last - 1 - place) for last, place in ((up, row), (across, column)))
            return np.column_stack([x, y, np.zeros(len(x))]) * self.square
        x, y = self.rows - 1.0 - row, self.columns - 1.0 - column
        return np.column_stack([x, y, np.zeros(len(x))]) * self.square

    def _along(self, corner: NDArray[np.intp]) -> Array:
        """Return how far corners lie along a line of tags, from its first one [tags' sides]."""
        tag, far_side = np.divmod(corner, 2)
        result: Array = tag * (1 + self.spacing) + far_side
        return result

    @cached_property
    def markers(self) -> cv2.aruco.CharucoBoard:
        """OpenCV's board of the same squares, with markers."""
        size = (self.columns, self.rows)
        marker = self.marker * self.square
        return cv2.aruco.CharucoBoard(size, self.square, marker, dictionary_of(self.dictionary))

    @cached_property
    def patterns(self) -> tuple[cv2.aruco.CharucoBoard, ...]:
        """The boards that may be meant: OpenCV's before 4.6, and calib.io's, begin with white.

        With an odd number of rows both are the same.
        """
        if self.rows % 2:
            return (self.markers,)
        legacy = cv2.aruco.CharucoBoard(
            (self.columns, self.rows),
            self.square,
            self.marker * self.square,
            dictionary_of(self.dictionary),
        )
        legacy.setLegacyPattern(True)
        return self.markers, legacy
