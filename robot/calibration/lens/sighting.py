"""Finds a printed board in a picture, or says why it is of no use."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.board import Board
from robot.calibration.lens.corner_check import in_place
from robot.errors import BrickPoseError
from robot.geometry import Array

Grey = NDArray[np.uint8]
"""(h, w)"""

LEAST_CORNERS = 8
"""Fewest corners of a board that is partly in sight: fewer hardly tell its pose."""
LEAST_INNER = 3
"""Fewest inner corners along a side by which OpenCV finds a chessboard."""
REFINE = cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4
SHARE = 0.3
"""Reach of the search for the exact corner, as a share of the distance to the next."""
REACH_PX = 2, 11
"""Its least and its greatest reach [px]."""
WIDEST_EDGE = 0.35
"""Wider edges, as a share of the distance between corners, make corners uncertain."""
BLURRED_PX, BLURRED = 6.0, 0.006
"""Edges of sharp pictures are some 3 px wide; wider than this, and than this share of the picture,
the camera moved or is out of focus."""
RIGHT = 0.8
"""Share of the corners that must lie on one grid."""
GOES_ON = 0.7
"""A saddle at least this strong, relative to those of the corners, is another corner."""


class SightingError(BrickPoseError, ValueError):
    """A picture shows no board that is of use; the message says why."""


@dataclass(frozen=True)
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


def find_board(picture: Grey, board: Board, *, hurried: bool = False) -> Sighting:
    """Find the corners of a board in a grey picture (h, w).

    A chessboard looks the same from two sides (a square one from four): which of them is up is not
    told.

    Args:
        picture: the picture.
        board: the board.
        hurried: search a fifth as long where there is no chessboard, for a running camera.

    Raises:
        SightingError: it is not there, not whole, mirrored, blurred, or has other squares.
    """
    size = picture.shape[1], picture.shape[0]
    if board.kind == "charuco":
        ids, pixels = _find_markers(picture, board)
    else:
        ids, pixels = _find_chessboard(picture, board, hurried)
    good = in_place(board.corners[ids, :2], pixels)
    if good.sum() < max(LEAST_CORNERS, RIGHT * len(good)):
        raise SightingError(f"{(~good).sum()} of {len(good)} corners do not lie on one grid")
    ids, pixels = ids[good], pixels[good]
    seen = Sighting(ids, pixels, size)
    width, apart = _edge_width(picture, seen, board)
    if width > max(BLURRED_PX, BLURRED * size[0]) or width > WIDEST_EDGE * apart:
        raise SightingError(f"blurred: edges are {width:.1f} px wide, {apart:.0f} px apart")
    return Sighting(ids, pixels, size, width)


def _find_chessboard(picture: Grey, board: Board, hurried: bool) -> tuple[NDArray[np.intp], Array]:
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
    grid = grid if ax * dy - ay * dx > 0 else grid[:, ::-1]
    reach = int(np.clip(SHARE * _least_distance(grid), *REACH_PX))
    given = grid.reshape(-1, 1, 2).astype(np.float32)
    refined = cv2.cornerSubPix(picture, given, (reach, reach), (-1, -1), REFINE)
    return np.asarray(refined, np.float64).reshape(grid.shape)


def _least_distance(grid: Array) -> float:
    steps = (np.linalg.norm(np.diff(grid, axis=axis), axis=-1) for axis in (0, 1))
    return float(min(step.min() for step in steps))


def _why_not(picture: Grey, board: Board) -> str:
    """Return why no whole chessboard was found."""
    seen, _, marks = cv2.findChessboardCornersSBWithMeta(picture, (3, 3), cv2.CALIB_CB_LARGER)
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
    tones = [
        _tones(picture, flat + sign * around * way) * (1 if place == 0 else -1)
        for place, way in enumerate(ways)
        for sign in (1, -1)
    ]
    return np.abs(sum(tones, np.zeros(len(flat))))


def _tones(picture: Grey, points: Array) -> Array:
    """Return the brightness at points (n, 2)."""
    if not len(points):
        return np.empty(0)
    x, y = points.T.astype(np.float32)
    return np.asarray(cv2.remap(picture, x, y, cv2.INTER_LINEAR), np.float64).ravel()


def _find_markers(picture: Grey, board: Board) -> tuple[NDArray[np.intp], Array]:
    detector = cv2.aruco.CharucoDetector(board.markers)
    corners, ids, _, marker_ids = detector.detectBoard(picture)
    if ids is None or len(ids) < LEAST_CORNERS:
        raise SightingError(_why_no_markers(picture, detector, ids, marker_ids))
    places = np.asarray(ids, np.intp).ravel()
    rows, columns = np.divmod(places, board.inner[0])
    if len(set(rows.tolist())) < 2 or len(set(columns.tolist())) < 2:
        raise SightingError("only one row of the board's corners is in sight")
    return places, _refined_beside_markers(picture, board, places, np.asarray(corners))


def _refined_beside_markers(
    picture: Grey, board: Board, ids: NDArray[np.intp], corners: NDArray[np.float32]
) -> Array:
    """Search for the exact corners (k, 2), as far around as there is no marker."""
    coarse = Sighting(ids, corners.reshape(-1, 2).astype(np.float64), (0, 0))
    ends = [np.array(list(_pairs(coarse, board, step))) for step in (1, board.inner[0])]
    apart = min(
        (float(np.linalg.norm(np.diff(pair, axis=1), axis=-1).min()) for pair in ends if len(pair)),
        default=0.0,
    )
    reach = int(np.clip(0.9 * (1 - board.marker) / 2 * apart, *REACH_PX))
    given = corners.reshape(-1, 1, 2).astype(np.float32)
    refined = cv2.cornerSubPix(picture, given, (reach, reach), (-1, -1), REFINE)
    return np.asarray(refined, np.float64).reshape(-1, 2)


def _why_no_markers(
    picture: Grey, detector: cv2.aruco.CharucoDetector, ids: object, marker_ids: object
) -> str:
    flipped = np.ascontiguousarray(picture[:, ::-1])
    _, turned, _, turned_markers = detector.detectBoard(flipped)
    if _count(turned) >= LEAST_CORNERS or _count(turned_markers) > 2 * _count(marker_ids) + 3:
        return "mirrored"
    return (
        f"{_count(ids)} corners of the charuco board in sight, {_count(marker_ids)} markers read; "
        f"valid is {LEAST_CORNERS} corners or more: do squares and markers have the given sizes?"
    )


def _count(found_ids: object) -> int:
    return 0 if found_ids is None else len(np.asarray(found_ids))


def _edge_width(picture: Grey, seen: Sighting, board: Board) -> tuple[float, float]:
    """Return the width of edges, and the distance between corners [px].

    The width is the height of an edge by its greatest slope, in the middle between two corners;
    the median of all edges of a direction, and the greater one of both directions: a camera that
    moved blurs those across its way.
    """
    widths, distances = [], []
    for step in (1, board.inner[0]):
        ends = np.array(list(_pairs(seen, board, step)))
        if not len(ends):
            continue
        along = ends[:, 1] - ends[:, 0]
        apart = np.hypot(*along.T)
        reach = np.clip(SHARE * apart, 3, 15)[:, None] * np.linspace(-1, 1, 41)
        normal = np.column_stack([-along[:, 1], along[:, 0]]) / apart[:, None]
        points = ends.mean(axis=1)[:, None] + reach[:, :, None] * normal[:, None]
        tones = _tones(picture, points.reshape(-1, 2)).reshape(reach.shape)
        slope = np.abs(np.diff(tones, axis=1) / np.diff(reach, axis=1)).max(axis=1)
        widths.append(float(np.median(np.ptp(tones, axis=1) / np.maximum(slope, 1e-9))))
        distances.append(float(np.median(apart)))
    return (max(widths), min(distances)) if widths else (0.0, np.inf)


def _pairs(seen: Sighting, board: Board, step: int) -> Iterator[tuple[Array, Array]]:
    """Yield the places of neighbouring corners; a step of 1 is along a row."""
    across = board.inner[0]
    for number, place in seen.places.items():
        if step == 1 and (number + 1) % across == 0:
            continue
        other = seen.places.get(number + step)
        if other is not None:
            yield place, other
