"""Finds a chessboard in a picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.board import Board
from robot.calibration.lens.sighting import REACH_PX, REFINE, SHARE, Grey, SightingError, tones
from robot.geometry import Array

LEAST_INNER = 3
"""Fewest inner corners along a side by which OpenCV finds a chessboard."""
LONGEST_PX, SHRUNK_PX = 2000, 1280
"""A longer picture [px] is shrunk to this length before a board is searched for; then the corners
are found exactly in the picture itself. OpenCV took 14 s for a picture of 12 megapixels.
Half and twice of the first: nothing changes there. Half of the second: the same corners; twice:
10 s instead of 1 where a part of a board is in sight."""
GOES_ON = 0.7
"""A saddle at least this strong, relative to those of the corners, is another corner."""


def find_chessboard(picture: Grey, board: Board, hurried: bool) -> tuple[NDArray[np.intp], Array]:
    """Return numbers (k,) and places (k, 2) of the corners, all of which must be in sight.

    Raises:
        SightingError: they are not, or the board has other squares.
    """
    if min(board.inner) < LEAST_INNER:
        raise SightingError(
            f"a {board.words} is too small to be found; valid are {LEAST_INNER} inner corners or "
            "more along each side"
        )
    grid = _grid(picture, board.inner, hurried)
    if grid is None:
        raise SightingError(_why_not(picture, board))
    beyond = _beyond(picture, grid)
    if any(beyond):
        across, up = board.inner[0] + beyond[0], board.inner[1] + beyond[1]
        raise SightingError(
            f"the board has more corners than {board.inner[0]} x {board.inner[1]}: "
            f"{across} x {up} or more"
        )
    return np.arange(board.inner[0] * board.inner[1]), grid.reshape(-1, 2)


def _grid(picture: Grey, inner: tuple[int, int], hurried: bool) -> Array | None:
    """Return the corners (up, across, 2) of a chessboard, not mirrored; None without one."""
    share = _searched_share(picture)
    grid = _search(_shrunk(picture, share), inner, hurried)
    if grid is None:
        return None
    # The middle of the first pixel is half of a shrunk pixel's way into it.
    grid = (grid + 0.5) / share - 0.5
    reach = int(np.clip(SHARE * _least_distance(grid), *REACH_PX))
    given = grid.reshape(-1, 1, 2).astype(np.float32)
    refined = cv2.cornerSubPix(picture, given, (reach, reach), (-1, -1), REFINE)
    return np.asarray(refined, np.float64).reshape(grid.shape)


def _searched_share(picture: Grey) -> float:
    """Return how much shorter a picture is searched than it is."""
    longer = max(picture.shape)
    return SHRUNK_PX / longer if longer > LONGEST_PX else 1.0


def _shrunk(picture: Grey, share: float) -> Grey:
    if share == 1.0:
        return picture
    smaller = cv2.resize(picture, None, fx=share, fy=share, interpolation=cv2.INTER_AREA)
    return np.asarray(smaller, np.uint8)


def _search(picture: Grey, inner: tuple[int, int], hurried: bool) -> Array | None:
    """Return about where the corners (up, across, 2) are, not mirrored; None without them."""
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH + cv2.CALIB_CB_NORMALIZE_IMAGE
    # Without a board the first search takes ten times as long as the second one.
    flags += cv2.CALIB_CB_FAST_CHECK if hurried else 0
    seen, corners = cv2.findChessboardCorners(picture, inner, flags=flags)
    if not seen:
        seen, corners = cv2.findChessboardCornersSB(
            picture, inner, flags=cv2.CALIB_CB_NORMALIZE_IMAGE
        )
    if not seen:
        return None
    grid = np.asarray(corners, np.float64).reshape(inner[1], inner[0], 2)
    along, down = grid[:, -1] - grid[:, 0], grid[-1] - grid[0]
    (ax, ay), (dx, dy) = along.mean(axis=0), down.mean(axis=0)
    return grid if ax * dy - ay * dx > 0 else grid[:, ::-1]


def _least_distance(grid: Array) -> float:
    steps = (np.linalg.norm(np.diff(grid, axis=axis), axis=-1) for axis in (0, 1))
    return float(min(step.min() for step in steps))


def _why_not(picture: Grey, board: Board) -> str:
    """Return why no whole chessboard was found."""
    searched = _shrunk(picture, _searched_share(picture))
    seen, _, marks = cv2.findChessboardCornersSBWithMeta(searched, (3, 3), cv2.CALIB_CB_LARGER)
    across, up = board.inner
    if not seen:
        return f"no chessboard of {across} x {up} inner corners in sight"
    rows, columns = sorted(np.asarray(marks).shape[:2])
    return (
        f"no whole chessboard of {across} x {up} inner corners, but {columns} x {rows} of some: "
        "cut off, covered, in bad light, or another board"
    )


def _beyond(picture: Grey, grid: Array) -> tuple[int, int]:
    """Return whether the squares go on beyond the corners (up, across, 2): across, and up."""
    usual = np.median(_saddles(picture, grid[1:-1, 1:-1], grid))
    result = [0, 0]
    for axis, turned in ((0, grid.swapaxes(0, 1)), (1, grid)):
        for lines in (turned, turned[::-1]):
            # The next line of corners, if the squares went on: distances change little by little.
            next_line = 3 * lines[0] - 3 * lines[1] + lines[2] if len(lines) > 2 else None
            if next_line is None:
                continue
            answers = _saddles(picture, next_line[None, 1:-1], grid)
            if len(answers) and np.median(answers) > GOES_ON * usual:
                result[axis] += 1
    return result[0], result[1]


def _saddles(picture: Grey, points: Array, grid: Array) -> Array:
    """Return how strongly two tones alternate around points (..., 2) inside the picture."""
    around = 0.3 * _least_distance(grid)
    along = (grid[:, 1:] - grid[:, :-1]).reshape(-1, 2).mean(axis=0)
    down = (grid[1:] - grid[:-1]).reshape(-1, 2).mean(axis=0)
    ways = [along / np.hypot(*along) + sign * down / np.hypot(*down) for sign in (1, -1)]
    flat = points.reshape(-1, 2)
    reach = around * max(np.abs(way).max() for way in ways)
    low, high = flat.min(axis=1) > reach, (flat < np.array(picture.shape[::-1]) - 1 - reach)
    flat = flat[low & high.all(axis=1)]
    parts = [
        tones(picture, flat + sign * around * way) * (1 if index == 0 else -1)
        for index, way in enumerate(ways)
        for sign in (1, -1)
    ]
    return np.abs(sum(parts, np.zeros(len(flat))))
