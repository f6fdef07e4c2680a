"""Pictures of a running camera are taken when the board is sharp, still and somewhere new."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import pytest
from board_pictures import CHARUCO, CHESSBOARD, lens_of, picture, pose, poses

from robot.calibration.lens.board import Board
from robot.calibration.lens.coverage import TILTS, Coverage
from robot.calibration.lens.guide import USUAL_PICTURES, BoardView, LensGuide
from robot.calibration.lens.sighting import Grey

LENS = lens_of()
EVERY_S = 0.25
TILT = (0.3, 0.3, 0.0)


def seen(aim: tuple[float, float], *, away: float = 0.5, board: Board = CHESSBOARD) -> Grey:
    rng = np.random.default_rng(round(sum(aim)))
    return picture(board, pose(board, LENS, aim, away, TILT), rng)


def looks(guide: LensGuide, *pictures: Grey, start: float = 0.0) -> list[BoardView]:
    return [guide.look(start + EVERY_S * k, grey) for k, grey in enumerate(pictures)]


@pytest.mark.parametrize("board", [CHESSBOARD, CHARUCO], ids=lambda board: board.kind)
def test_a_board_counts_once_when_it_is_held_still(board: Board) -> None:
    guide = LensGuide(board)
    there = seen((320, 240), board=board)
    first, second, third = looks(guide, there, there, there)
    assert (first.verdict, first.words) == ("moving", "hold it still")
    assert (second.verdict, second.words) == ("taken", "")
    assert third.verdict == "known" and "move it or tilt it" in third.words
    assert len(guide.collection.seen) == 1
    assert first.sighting is not None and len(first.sighting.pixels) == len(board.corners)


def test_a_board_that_moves_is_not_taken() -> None:
    guide = LensGuide(CHESSBOARD)
    moving = looks(guide, *(seen((300 + 8 * k, 240)) for k in range(4)))
    assert {look.verdict for look in moving} == {"moving"}
    assert not guide.collection.seen


def test_after_a_gap_nobody_knows_whether_it_was_still() -> None:
    guide = LensGuide(CHESSBOARD)
    there = seen((320, 240))
    guide.look(0.0, there)
    assert guide.look(2.5, there).words == "hold it still"
    assert guide.look(2.5, there).words == "hold it still"  # the same picture once more
    assert guide.look(3.75, there).verdict == "taken"


def test_a_slow_computer_takes_what_did_not_move_meanwhile() -> None:
    guide = LensGuide(CHESSBOARD)
    guide.look(0.0, seen((320, 240)))
    assert guide.look(1.8, seen((328, 240))).verdict == "moving"
    assert guide.look(3.6, seen((329, 240))).verdict == "taken"


def test_what_is_of_no_use_is_told_and_interrupts() -> None:
    guide = LensGuide(CHESSBOARD)
    there = seen((320, 240))
    blurred = np.asarray(cv2.GaussianBlur(there, (0, 0), 5))
    empty = np.full((480, 640), 90, np.uint8)
    cut_off = there.copy()
    cut_off[:, :320] = 100
    _, second, third, fourth = looks(guide, there, blurred, empty, cut_off)
    assert second.words.startswith("blurred")
    assert "in sight" in third.words and third.sighting is None
    assert fourth.words.startswith("no whole chessboard")
    assert guide.look(1.0, there).words == "hold it still"
    assert {look.verdict for look in (second, third, fourth)} == {"refused"}


@pytest.mark.slow
def test_the_steps_asked_for_change_until_nothing_is_missing() -> None:
    guide, rng = LensGuide(CHESSBOARD), np.random.default_rng(3)
    asked = [guide.next_steps]
    bars = [guide.coverage.bars]
    places = [
        *(pose(CHESSBOARD, LENS, aim, 0.85, (0.0, 0.0, 0.0))
          for aim in ((95, 65), (545, 65), (95, 415), (545, 415), (320, 80), (320, 400))),
        pose(CHESSBOARD, LENS, (320, 240), 0.26, (0.0, 0.0, 0.0)),
        *poses(CHESSBOARD, LENS, 14, rng),
    ]  # fmt: skip
    for number, place in enumerate(places):
        there = picture(CHESSBOARD, place, rng)
        looks(guide, there, there, start=number)
        asked.append(guide.next_steps)
        bars.append(guide.coverage.bars)
    assert asked[0][0] == "hold it nearer to the picture's upper left corner"
    assert asked[1][0] == "hold it nearer to the picture's upper right corner"
    assert "bring it nearer, until it fills half of the picture" in asked[6]
    assert "bring it nearer, until it fills half of the picture" not in asked[7]
    assert len(guide.collection.seen) >= USUAL_PICTURES
    assert asked[-1] == [] and set(bars[-1].values()) == {1.0}
    for before, after in pairwise(bars):
        assert all(after[name] >= before[name] for name in before)
    lens = guide.collection.calibrate().lens
    assert lens.matrix[0, 0] == pytest.approx(LENS.matrix[0, 0], abs=2)


def test_when_all_is_covered_some_more_are_asked_for() -> None:
    guide = LensGuide(CHESSBOARD)
    guide.coverage = Coverage(np.ones((3, 4), bool), dict.fromkeys(TILTS, 1.0), 1.0, 0.0)
    assert guide.next_steps == [f"{USUAL_PICTURES} more, each from somewhere new"]
