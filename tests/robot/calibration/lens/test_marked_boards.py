"""Boards with markers of other programs are found: corners lie where the camera saw them."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robot.calibration.lens.board import DICTIONARIES, Board, dictionary_of
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.sighting import Grey, SightingError
from robot.geometry import Array
from robot.settings import SettingError

pytestmark = pytest.mark.slow

SIZE, FINER = (1280, 800), 4
K = np.array([[900.0, 0, 640], [0, 900, 400], [0, 0, 1]])
CELL = 4
"""Pixels of a printed page for each cell of a tag."""


def seen(page: Grey, metre: float, corner: tuple[float, float], tilt: Array) -> tuple[Grey, Array]:
    """A picture of a page, and the homography (3, 3) from the board's x, y [m] to it.

    Args:
        page: printed, with ``metre`` pixels for each metre.
        corner: pixel of the page where the board's frame begins: x up the page, y to its left.
        tilt: rotation vector of the page.
    """
    page_from_board = np.array([[0, -metre, corner[0] - 0.5], [-metre, 0, corner[1] - 0.5],
                                [0, 0, 1]])  # fmt: skip
    height, width = page.shape
    size = max(width, height) / metre
    turn = Rotation.from_rotvec(tilt).as_matrix()
    middle = np.array([[1 / metre, 0, -width / 2 / metre], [0, 1 / metre, -height / 2 / metre],
                       [0, 0, 1]])  # fmt: skip
    place = np.column_stack([turn[:, :2], [0.02 * size, -0.03 * size, 1.35 * size]])
    view = K @ place @ middle
    # A pixel is the mean of all that it sees.
    finer = np.array([[FINER, 0, (FINER - 1) / 2], [0, FINER, (FINER - 1) / 2], [0, 0, 1]])
    size_px = FINER * SIZE[0], FINER * SIZE[1]
    flat = cv2.warpPerspective(page, finer @ view, size_px, borderValue=210.0)
    flat = cv2.resize(flat, SIZE, interpolation=cv2.INTER_AREA)
    rng = np.random.default_rng(0)
    grey = cv2.GaussianBlur(flat, (0, 0), 0.8) * 0.7 + 30 + rng.normal(0, 2, flat.shape)
    return np.clip(grey, 0, 255).astype(np.uint8), view @ page_from_board


def expected(board: Board, view: Array) -> Array:
    flat = board.corners[:, None, :2]
    return np.asarray(cv2.perspectiveTransform(flat, view)).reshape(-1, 2)


TILTS = [(0.0, 0.0, 0.0), (0.5, 0.1, 0.2), (-0.3, 0.5, -2.0), (0.1, -0.4, math.pi)]


def charuco(board: Board, *, legacy: bool) -> Grey:
    """The page as OpenCV draws it, with 80 px for each square and a margin of 40 px."""
    drawing = cv2.aruco.CharucoBoard(
        (board.columns, board.rows), 0.025, board.marker * 0.025, dictionary_of(board.dictionary)
    )
    drawing.setLegacyPattern(legacy)
    size = 80 * board.columns + 80, 80 * board.rows + 80
    return np.asarray(drawing.generateImage(size, marginSize=40), np.uint8)


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize("legacy", [False, True])
@pytest.mark.parametrize(
    ("columns", "rows", "dictionary"),
    [
        (7, 10, "5x5_250"),
        (7, 9, "4x4_100"),
        (6, 8, "6x6_1000"),
        (5, 6, "7x7_50"),
        (8, 6, "apriltag_36h11"),
    ],
)
def test_charuco_boards_of_both_patterns_are_found(
    columns: int, rows: int, dictionary: str, legacy: bool, tilt: Array
) -> None:
    board = Board("charuco", columns, rows, 0.025, dictionary=dictionary)
    page = charuco(board, legacy=legacy)
    picture, view = seen(page, 80 / 0.025, (page.shape[1] - 40, page.shape[0] - 40), tilt)
    found = find_board(picture, board)
    assert len(found.ids) > 0.8 * (columns - 1) * (rows - 1)
    off = np.linalg.norm(found.pixels - expected(board, view)[found.ids], axis=1)
    assert np.median(off) < 0.1 and off.max() < 0.5


@pytest.mark.parametrize("legacy", [False, True])
def test_what_another_board_is_is_told(legacy: bool) -> None:
    board = Board("charuco", 6, 10, 0.025)
    page = charuco(board, legacy=legacy)
    picture, _ = seen(page, 80 / 0.025, (0, 0), np.array([0.2, 0.1, 0]))
    with pytest.raises(SightingError, match="it shows 6 x 10 squares"):
        find_board(picture, Board("charuco", 10, 6, 0.025))
    with pytest.raises(SightingError, match="30 markers of the dictionary 5x5"):
        find_board(picture, Board("charuco", 6, 10, 0.025, dictionary="4x4_50"))
    with pytest.raises(SightingError, match="mirrored"):
        find_board(picture[:, ::-1].copy(), board)


def tags(board: Board, border: int, *, squares: bool, from_below: bool, turned: int) -> Grey:
    """A grid of tags: Kalibr's has squares between them, a border of 2, and counts from below."""
    side = CELL * 5 * (6 + 2 * border)
    gap = round(board.spacing * side)
    step = side + gap
    height, width = board.rows * step + gap, board.columns * step + gap
    page = np.full((height + 80, width + 80), 255, np.uint8)
    for row in range(board.rows + 1):
        for column in range(board.columns + 1):
            if squares:
                page[40 + row * step :, 40 + column * step :][:gap, :gap] = 0
    for row in range(board.rows):
        for column in range(board.columns):
            counted = board.rows - 1 - row if from_below else row
            number = counted * board.columns + column
            tag = cv2.aruco.generateImageMarker(
                dictionary_of(board.dictionary), number, 6 + 2 * border, borderBits=border
            )
            tag = np.rot90(tag, turned).repeat(5 * CELL, 0).repeat(5 * CELL, 1)
            page[40 + gap + row * step :, 40 + gap + column * step :][:side, :side] = tag
    return page


@pytest.mark.parametrize("tilt", TILTS)
@pytest.mark.parametrize(
    ("border", "squares", "from_below", "turned"),
    [(2, True, True, 2), (2, True, True, 0), (1, True, True, 2), (1, False, False, 0)],
)
def test_grids_of_apriltags_are_found(
    border: int, squares: bool, from_below: bool, turned: int, tilt: Array
) -> None:
    board = Board("aprilgrid", 6, 5, 0.03, dictionary="apriltag_36h11")
    page = tags(board, border, squares=squares, from_below=from_below, turned=turned)
    side = CELL * 5 * (6 + 2 * border)
    gap = round(0.3 * side)
    corner = page.shape[1] - 40 - gap, page.shape[0] - 40 - gap
    picture, view = seen(page, side / 0.03, corner, tilt)
    found = find_board(picture, board)
    assert len(found.ids) > 0.7 * 4 * 30
    off = np.linalg.norm(found.pixels - expected(board, view)[found.ids], axis=1)
    # A blurred corner that no square continues is rounded, which moves it outward.
    assert np.median(off) < (0.15 if squares else 0.25) and off.max() < 0.7


def test_another_grid_of_tags_is_refused() -> None:
    board = Board("aprilgrid", 6, 5, 0.03, dictionary="apriltag_36h11")
    picture, _ = seen(
        tags(board, 2, squares=True, from_below=True, turned=2), 4000.0, (0, 0), np.zeros(3)
    )
    with pytest.raises(SightingError, match="do not lie as on a aprilgrid of 5 x 6 tags"):
        find_board(picture, Board("aprilgrid", 5, 6, 0.03, dictionary="apriltag_36h11"))
    with pytest.raises(SightingError, match="0 tags of apriltag_36h11"):
        find_board(np.full((480, 640), 128, np.uint8), board)


def test_every_dictionary_has_a_board() -> None:
    for name in DICTIONARIES:
        assert Board("charuco", 5, 7, 0.03, dictionary=name).markers.getIds().size == 17
    with pytest.raises(SettingError, match="has 60 markers, and there are 50 of 4x4_50"):
        Board("charuco", 12, 10, 0.03, dictionary="4x4_50")
