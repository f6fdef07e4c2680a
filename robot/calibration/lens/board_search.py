"""Finds a printed board in a picture, or says why it is of no use."""

from __future__ import annotations

import numpy as np

from robot.calibration.lens.aprilgrid import find_aprilgrid
from robot.calibration.lens.board import Board
from robot.calibration.lens.charuco import find_charuco
from robot.calibration.lens.chessboard import find_chessboard
from robot.calibration.lens.corner_check import in_place
from robot.calibration.lens.sighting import (
    LEAST_CORNERS,
    SHARE,
    Grey,
    Sighting,
    SightingError,
    pairs,
    tones,
)

WIDEST_EDGE = 0.35
"""Wider edges, as a share of the distance between corners, make corners uncertain."""
BLURRED_PX, BLURRED = 6.0, 0.006
"""Edges of sharp pictures are some 3 px wide; wider than this, and than this share of the picture,
the camera moved or is out of focus."""
RIGHT = 0.8
"""Share of the corners that must lie on one grid."""


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
        ids, pixels = find_charuco(picture, board, hurried)
    elif board.kind == "aprilgrid":
        ids, pixels = find_aprilgrid(picture, board)
    else:
        ids, pixels = find_chessboard(picture, board, hurried)
    good = in_place(board.corners[ids, :2], pixels)
    if good.sum() < max(LEAST_CORNERS, RIGHT * len(good)):
        raise SightingError(f"{(~good).sum()} of {len(good)} corners do not lie on one grid")
    ids, pixels = ids[good], pixels[good]
    seen = Sighting(ids, pixels, size)
    width, apart = _edge_width(picture, seen, board)
    if width > max(BLURRED_PX, BLURRED * size[0]) or width > WIDEST_EDGE * apart:
        raise SightingError(f"blurred: edges are {width:.1f} px wide, {apart:.0f} px apart")
    return Sighting(ids, pixels, size, width)


def _edge_width(picture: Grey, seen: Sighting, board: Board) -> tuple[float, float]:
    """Return the width of edges, and the distance between corners [px].

    The width is the height of an edge by its greatest slope, in the middle between two corners;
    the median of all edges of a direction, and the greater one of both directions: a camera that
    moved blurs those across its way.
    """
    widths, distances = [], []
    # Edges of a blurred picture are wider than those that are allowed.
    farthest = 2.5 * max(BLURRED_PX, BLURRED * seen.size[0])
    for step in (1, board.inner[0]):
        ends = np.array(list(pairs(seen, board, step)))
        if not len(ends):
            continue
        along = ends[:, 1] - ends[:, 0]
        apart = np.hypot(*along.T)
        reach = np.clip(SHARE * apart, 3, farthest)[:, None] * np.linspace(-1, 1, 41)
        normal = np.column_stack([-along[:, 1], along[:, 0]]) / apart[:, None]
        points = ends.mean(axis=1)[:, None] + reach[:, :, None] * normal[:, None]
        across = tones(picture, points.reshape(-1, 2)).reshape(reach.shape)
        slope = np.abs(np.diff(across, axis=1) / np.diff(reach, axis=1)).max(axis=1)
        widths.append(float(np.median(np.ptp(across, axis=1) / np.maximum(slope, 1e-9))))
        distances.append(float(np.median(apart)))
    return (max(widths), min(distances)) if widths else (0.0, np.inf)
