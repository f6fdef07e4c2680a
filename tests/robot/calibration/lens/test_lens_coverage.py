"""What pictures of a board still lack is said in words, from the first picture on."""

from __future__ import annotations

import math

import numpy as np
import pytest
from board_pictures import CHARUCO, CHESSBOARD, lens_of, pose, poses
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from robot.calibration.lens.board import Board
from robot.calibration.lens.coverage import (
    COLUMNS,
    FAR,
    NEAR,
    ROWS,
    TILT,
    TILTS,
    Coverage,
    missing,
    parts_seen,
    tilt,
)
from robot.calibration.lens.sighting import Sighting

LENS = lens_of()
MIDDLE = (320.0, 240.0)


def seen(
    board: Board, aim: tuple[float, float], away: float, tilts: tuple[float, ...] = (0, 0, 0)
) -> Sighting:
    place = pose(board, LENS, aim, away, tilts)
    pixels = LENS.project(board.corners @ place[:3, :3].T + place[:3, 3])
    return Sighting(np.arange(len(pixels)), pixels, (640, 480), 2.5)


def farther(sighting: Sighting, board: Board) -> str:
    """Which side of the board is smaller in the picture."""
    across, up = board.inner
    grid = sighting.pixels.reshape(up, across, 2)
    sides = {"left": grid[:, 0], "right": grid[:, -1], "upper": grid[0], "lower": grid[-1]}
    lengths = {side: float(np.linalg.norm(line[-1] - line[0])) for side, line in sides.items()}
    shorter = {
        side: lengths[other] / lengths[side]
        for pair in (("left", "right"), ("upper", "lower"))
        for side, other in (pair, pair[::-1])
    }
    return max(shorter, key=lambda side: shorter[side])


@pytest.mark.parametrize("board", [CHESSBOARD, CHARUCO], ids=lambda board: board.kind)
@pytest.mark.parametrize("tilts", [(0.6, 0, 0), (-0.6, 0, 0), (0, 0.6, 0), (0, -0.6, 0)])
def test_the_side_that_is_farther_is_named(board: Board, tilts: tuple[float, ...]) -> None:
    sighting = seen(board, MIDDLE, 0.5, tilts)
    angle, side = tilt(sighting, board)
    assert angle == pytest.approx(0.6, abs=0.12)
    assert side == farther(sighting, board)


def test_a_board_that_faces_the_camera_is_not_tilted() -> None:
    assert tilt(seen(CHESSBOARD, MIDDLE, 0.5), CHESSBOARD)[0] < math.radians(5)


def test_without_pictures_everything_is_missing() -> None:
    words = missing([], CHESSBOARD)
    assert "upper left corner" in words[0] and "lower right corner" in words[0]
    assert "the left side, the right side, the upper side, the lower side" in words[1]
    assert len(words) == 4


def test_one_picture_tells_what_the_next_should_be() -> None:
    near_left = seen(CHESSBOARD, (180, 240), 0.45, (0, 0.6, 0))
    words = missing([near_left], CHESSBOARD)
    assert "right" in words[0] and "middle left" not in words[0]
    gone = farther(near_left, CHESSBOARD)
    assert f"{gone}," not in words[1] and f" {gone} side" not in words[1]


def test_in_the_end_nothing_is_missing() -> None:
    rng = np.random.default_rng(0)
    views = []
    for place in poses(CHESSBOARD, LENS, 40, rng):
        pixels = LENS.project(CHESSBOARD.corners @ place[:3, :3].T + place[:3, 3])
        views.append(Sighting(np.arange(54), pixels, (640, 480), 2.5))
    views += [seen(CHESSBOARD, MIDDLE, 0.24), seen(CHESSBOARD, MIDDLE, 0.9)]
    for corner in ((90, 60), (550, 60), (90, 420), (550, 420)):
        views.append(seen(CHESSBOARD, corner, 1.2))
    assert parts_seen(views).min() > 3
    assert missing(views, CHESSBOARD) == []
    assert Coverage.of(views, CHESSBOARD).next_steps == []


@given(
    hnp.arrays(bool, (ROWS, COLUMNS), elements=st.sampled_from([True, True, True, False])),
    st.lists(st.sampled_from([0.0, 0.3, TILT, 0.9]), min_size=4, max_size=4),
    st.sampled_from([0.0, 0.2, NEAR, 0.8]),
    st.sampled_from([0.05, FAR, 0.3, 1.0]),
)
def test_the_bars_are_full_when_nothing_is_missing_and_only_then(parts, tilts, nearest, farthest):
    coverage = Coverage(parts, dict(zip(TILTS, tilts, strict=True)), nearest, farthest)
    bars = coverage.bars
    assert all(0 <= bar <= 1 for bar in bars.values())
    assert (min(bars.values()) == 1) == (coverage.missing == []) == (coverage.next_steps == [])


def test_the_bars_are_empty_without_pictures() -> None:
    assert set(Coverage.of([], CHESSBOARD).bars.values()) == {0.0}


def test_the_next_step_is_about_one_place_and_one_tilt() -> None:
    steps = Coverage.of([seen(CHESSBOARD, MIDDLE, 0.5, (0.6, 0, 0))], CHESSBOARD).next_steps
    assert steps[0] == "hold it nearer to the picture's upper left corner"
    assert steps[1] == "tilt its right edge toward the camera"


@pytest.mark.parametrize("edge", TILTS)
def test_whoever_tilts_as_asked_is_not_asked_again(edge: str) -> None:
    way = {"left": (0, -0.6), "right": (0, 0.6), "upper": (-0.6, 0), "lower": (0.6, 0)}
    for tilts in (way[edge], tuple(-angle for angle in way[edge])):
        sighting = seen(CHESSBOARD, MIDDLE, 0.5, (*tilts, 0))
        _, step = TILTS[farther(sighting, CHESSBOARD)]
        steps = Coverage.of([sighting], CHESSBOARD).next_steps
        assert step not in steps
