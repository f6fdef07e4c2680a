"""Finds a grid of AprilTags in a picture, as Kalibr's aprilgrid or OpenCV's GridBoard.

Between Kalibr's tags lie small black squares that touch their corners. So the picture is also
searched enlarged, with dark parts made thinner, which parts the tags from the squares.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.board import Board, dictionary_of
from robot.calibration.lens.sighting import REACH_PX, REFINE, Grey, SightingError
from robot.geometry import Array

BORDERS = (2, 1)
"""Widths of the tags' black borders, in cells: Kalibr's are 2 wide, others 1."""
ENLARGED, THINNER = 2, 3
"""How many times the picture is enlarged, and the side of what makes dark parts thinner [px]."""
LEAST_TAGS = 4
"""Fewest tags that tell how the grid lies."""
REACH = 0.4
"""Reach of the search for the exact corner, as a share of the gap between tags."""


def find_aprilgrid(picture: Grey, board: Board) -> tuple[NDArray[np.intp], Array]:
    """Return numbers (k,) and places (k, 2) of the corners of the tags.

    Raises:
        SightingError: there are too few tags, or they do not lie as the board has them.
    """
    tags = max((_tags(picture, board, border) for border in BORDERS), key=len)
    if len(tags) < LEAST_TAGS:
        raise SightingError(
            f"{len(tags)} tags of {board.dictionary} in sight; valid are {LEAST_TAGS} or more"
        )
    numbers = np.array(sorted(tags))
    seen = np.array([tags[number] for number in numbers])
    row, column = np.divmod(numbers, board.columns)
    if len(set(row)) < 2 or len(set(column)) < 2:
        raise SightingError("only one row of the board's tags is in sight")
    # Kalibr counts from the lower row, OpenCV from the upper one: the other way is mirrored.
    for below in (board.rows - 1 - row, row):
        ids = _corner_ids(board, below, column)
        pixels = _in_order(board, ids, seen)
        if pixels is not None:
            flat = ids.ravel()
            return flat, _refined(picture, pixels, board)
    raise SightingError(
        f"{len(tags)} tags of {board.dictionary} do not lie as on a {board.words}: has it "
        f"{board.columns} tags across and {board.rows} up?"
    )


def _tags(picture: Grey, board: Board, border: int) -> dict[int, Array]:
    """Return the corners (4, 2) of tags by their numbers."""
    settings = cv2.aruco.DetectorParameters()
    settings.markerBorderBits = border
    detector = cv2.aruco.ArucoDetector(dictionary_of(board.dictionary), settings)
    # The middle of the first pixel is half of an enlarged pixel's way into it.
    larger = cv2.resize(picture, None, fx=ENLARGED, fy=ENLARGED, interpolation=cv2.INTER_CUBIC)
    thinned = cv2.dilate(larger, np.ones((THINNER, THINNER), np.uint8))
    result: dict[int, Array] = {}
    for searched, scale in ((thinned, ENLARGED), (picture, 1)):
        corners, numbers, _ = detector.detectMarkers(searched)
        for number, four in zip(() if numbers is None else numbers.ravel(), corners, strict=True):
            if number < board.columns * board.rows:
                places = np.asarray(four, np.float64).reshape(4, 2)
                result[int(number)] = (places + 0.5) / scale - 0.5
    return result


def _corner_ids(board: Board, row: NDArray[np.intp], column: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the numbers (n, 4) of tags' corners, clockwise from the upper left."""
    across = board.inner[0]
    first = 2 * row * across + 2 * column
    return np.column_stack([first, first + 1, first + across + 1, first + across]).astype(np.intp)


def _in_order(board: Board, ids: NDArray[np.intp], seen: Array) -> Array | None:
    """Return the pixels (4 n, 2) of the corners; None if the tags lie otherwise, or mirrored.

    How a tag is turned differs between programs that draw it: what fits the board counts.
    """
    # Seen from the front, with x to the right and y down the page.
    page = -board.corners[:, [1, 0]]
    middles = page[ids].mean(axis=1)
    transform, fits = cv2.findHomography(middles, seen.mean(axis=1), cv2.RANSAC, 4.0)
    if transform is None or fits.mean() < 0.8:
        return None
    at_tags = cv2.perspectiveTransform(page[ids].reshape(-1, 1, 2), transform).reshape(-1, 4, 2)
    first, second = at_tags[:, 1] - at_tags[:, 0], at_tags[:, 3] - at_tags[:, 0]
    if (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] <= 0).any():
        return None
    distances = [
        float(np.linalg.norm(np.roll(seen, turn, axis=1) - at_tags, axis=-1).mean())
        for turn in range(4)
    ]
    return np.roll(seen, int(np.argmin(distances)), axis=1).reshape(-1, 2)


def _refined(picture: Grey, pixels: Array, board: Board) -> Array:
    four = pixels.reshape(-1, 4, 2)
    side = float(np.linalg.norm(four - np.roll(four, 1, axis=1), axis=-1).min())
    reach = int(np.clip(REACH * board.spacing * side, *REACH_PX))
    given = pixels.reshape(-1, 1, 2).astype(np.float32)
    refined = cv2.cornerSubPix(picture, given, (reach, reach), (-1, -1), REFINE)
    return np.asarray(refined, np.float64).reshape(-1, 2)
