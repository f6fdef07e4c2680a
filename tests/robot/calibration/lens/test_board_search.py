"""A board is found in stills of 12 megapixels as exactly as in the pictures of a small camera."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from board_pictures import CHARUCO, CHESSBOARD, PX_A_SQUARE, paper

from robot.calibration.lens.board import Board
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.sighting import Grey, SightingError
from robot.geometry import Array

pytestmark = pytest.mark.slow
WIDTH, HEIGHT = 4056, 3040


def still(board: Board, width: float = 2600.0) -> tuple[Grey, Array]:
    """A still of a tilted board that is so wide [px], and where its corners are (k, 2)."""
    drawn = paper(board)
    high, wide = drawn.shape
    ends = np.array([[0, 0], [wide, 0], [wide, high], [0, high]], np.float32)
    slanted = np.array([[0.0, 0.02], [1.0, 0.0], [0.94, 0.72], [0.05, 0.68]]) * width
    corner = np.array([WIDTH / 2 - width / 2, HEIGHT / 2 - 0.36 * width])
    moved = (slanted + corner).astype(np.float32)
    seen_from_page = cv2.getPerspectiveTransform(ends, moved)
    grey = cv2.warpPerspective(
        drawn, seen_from_page, (WIDTH, HEIGHT), flags=cv2.INTER_LINEAR, borderValue=120
    )
    noise = np.random.default_rng(3).normal(0, 3, grey.shape)
    noisy = np.clip(np.rint(grey + noise), 0, 255).astype(np.uint8)
    # x of a corner points up the page and y to its left, from its lower right corner.
    x, y = board.corners[:, 0] / board.square, board.corners[:, 1] / board.square
    page = np.column_stack([wide - PX_A_SQUARE * (1 + y), high - PX_A_SQUARE * (1 + x)]) - 0.5
    places = cv2.perspectiveTransform(page.reshape(-1, 1, 2), seen_from_page).reshape(-1, 2)
    return noisy, places


@pytest.mark.parametrize(
    ("board", "width"), [(CHESSBOARD, 2600.0), (CHESSBOARD, 560.0), (CHARUCO, 2600.0)], ids=str
)
def test_corners_of_a_large_still_are_exact(board: Board, width: float) -> None:
    grey, places = still(board, width)
    seen = find_board(grey, board)
    assert len(seen.ids) == len(board.corners)
    assert seen.size == (WIDTH, HEIGHT)
    expected = places[seen.ids]
    if board.kind == "chessboard":  # which side is up is not told
        expected = min(
            expected, expected[::-1], key=lambda one: float(np.abs(one - seen.pixels).max())
        )
    assert np.sqrt(np.mean((seen.pixels - expected) ** 2)) < 0.25


def test_a_blurred_still_is_called_blurred() -> None:
    grey, _ = still(CHESSBOARD)
    blurred = np.asarray(cv2.GaussianBlur(grey, (0, 0), 16), np.uint8)
    with pytest.raises(SightingError, match="blurred: edges are"):
        find_board(blurred, CHESSBOARD)


def test_a_still_without_a_board_says_so() -> None:
    with pytest.raises(SightingError, match="no chessboard of 9 x 6"):
        find_board(np.full((HEIGHT, WIDTH), 128, np.uint8), CHESSBOARD)
