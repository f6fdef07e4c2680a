"""Finds a chessboard with markers (ChArUco) in a picture."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from robot.calibration.lens.board import Board, dictionary_of
from robot.calibration.lens.sighting import (
    LEAST_CORNERS,
    REACH_PX,
    REFINE,
    Grey,
    Sighting,
    SightingError,
    pairs,
)
from robot.geometry import Array

LARGEST_DICTIONARIES = (
    "4x4_1000", "5x5_1000", "6x6_1000", "7x7_1000", "apriltag_36h11", "original",
)  # fmt: skip
"""In which the others are contained."""


def find_charuco(picture: Grey, board: Board, hurried: bool) -> tuple[NDArray[np.intp], Array]:
    """Return numbers (k,) and places (k, 2) of the corners in sight.

    Raises:
        SightingError: there are too few, or the picture is mirrored.
    """
    detector = cv2.aruco.CharucoDetector(board.markers)
    corners, ids, marker_corners, marker_ids = detector.detectBoard(picture)
    for pattern in board.patterns[1:]:
        if _count(ids) < LEAST_CORNERS <= _count(marker_ids):
            corners, ids, _, _ = cv2.aruco.CharucoDetector(pattern).detectBoard(
                picture, markerCorners=marker_corners, markerIds=marker_ids
            )
    if ids is None or len(ids) < LEAST_CORNERS:
        raise SightingError(_why_no_markers(picture, board, (ids, marker_ids), hurried))
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
    ends = [np.array(list(pairs(coarse, board, step))) for step in (1, board.inner[0])]
    apart = min(
        (float(np.linalg.norm(np.diff(pair, axis=1), axis=-1).min()) for pair in ends if len(pair)),
        default=0.0,
    )
    reach = int(np.clip(0.9 * (1 - board.marker) / 2 * apart, *REACH_PX))
    given = corners.reshape(-1, 1, 2).astype(np.float32)
    refined = cv2.cornerSubPix(picture, given, (reach, reach), (-1, -1), REFINE)
    return np.asarray(refined, np.float64).reshape(-1, 2)


def _why_no_markers(picture: Grey, board: Board, seen: tuple[object, object], hurried: bool) -> str:
    ids, marker_ids = seen
    flipped = np.ascontiguousarray(picture[:, ::-1])
    for pattern in board.patterns:
        _, turned, _, turned_markers = cv2.aruco.CharucoDetector(pattern).detectBoard(flipped)
        if _count(turned) >= LEAST_CORNERS or _count(turned_markers) > 2 * _count(marker_ids) + 3:
            return "mirrored"
    hint = "do squares and markers have the given sizes?"
    if hurried:
        pass  # other boards take long to be searched for
    elif _count(marker_ids) < LEAST_CORNERS:
        hint = _other_markers(picture, _count(marker_ids)) or hint
    elif board.rows != board.columns and _is_board(
        picture, replace(board, columns=board.rows, rows=board.columns)
    ):
        hint = f"it shows {board.rows} x {board.columns} squares (across x up)"
    return (
        f"{_count(ids)} corners of the charuco board in sight, {_count(marker_ids)} markers read; "
        f"valid is {LEAST_CORNERS} corners or more: {hint}"
    )


def _is_board(picture: Grey, board: Board) -> bool:
    return any(
        _count(cv2.aruco.CharucoDetector(pattern).detectBoard(picture)[1]) >= LEAST_CORNERS
        for pattern in board.patterns
    )


def _other_markers(picture: Grey, read: int) -> str | None:
    """Return a hint if a picture shows markers of another dictionary."""
    for name in LARGEST_DICTIONARIES:
        _, ids, _ = cv2.aruco.ArucoDetector(dictionary_of(name)).detectMarkers(picture)
        if _count(ids) >= max(LEAST_CORNERS, 2 * read):
            kind = name.rsplit("_", 1)[0] + "_..." if "x" in name else name
            return f"it shows {_count(ids)} markers of the dictionary {kind}"
    return None


def _count(found_ids: object) -> int:
    return 0 if found_ids is None else len(np.asarray(found_ids))
