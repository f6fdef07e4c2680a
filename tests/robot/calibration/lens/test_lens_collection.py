"""Pictures that are taken one after the other are judged at once, and the next one is asked for."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from board_pictures import CHESSBOARD, lens_of, picture, poses

from robot.calibration.lens.collection import PictureCollection
from robot.calibration.lens.lens_calibration import LensError
from robot.calibration.lens.sighting import Grey


@pytest.fixture(scope="module")
def pictures() -> list[Grey]:
    rng, lens = np.random.default_rng(5), lens_of()
    return [picture(CHESSBOARD, place, rng) for place in poses(CHESSBOARD, lens, 8, rng)]


@pytest.mark.slow
def test_what_is_missing_becomes_less_until_the_lens_is_known(pictures: list[Grey]) -> None:
    collection = PictureCollection(CHESSBOARD)
    everything = collection.coverage.missing
    assert len(everything) == 4
    for number, grey in enumerate(pictures):
        assert collection.add(str(number), grey) == ""
    assert len(collection.coverage.missing[0]) < len(everything[0])
    assert len(collection.coverage.missing) < 4
    lens = collection.calibrate().lens
    assert lens.matrix[0, 0] == pytest.approx(lens_of().matrix[0, 0], abs=3)


def test_a_picture_of_no_use_is_refused_at_once_and_not_kept(pictures: list[Grey]) -> None:
    collection = PictureCollection(CHESSBOARD)
    for number, grey in enumerate(pictures[:3]):
        collection.add(str(number), grey)
    before = dict(collection.seen)
    noisy = cv2.add(pictures[1], 3)
    assert collection.add("again", np.asarray(noisy)) == "repeated: the board is where it is in 1"
    blurred = np.asarray(cv2.GaussianBlur(pictures[4], (0, 0), 3))
    assert collection.add("soft", blurred).startswith("blurred")
    small = np.asarray(cv2.resize(pictures[4], None, fx=0.75, fy=0.75))
    assert collection.add("small", small) == "of 480 x 360 px; most are of 640 x 480 px"
    assert "no chessboard" in collection.add("empty", np.full((480, 640), 90, np.uint8))
    assert collection.seen == before
    with pytest.raises(LensError, match="3 pictures of 3 are of use; valid are 6 or more"):
        collection.calibrate()


def test_the_first_picture_decides_the_size(pictures: list[Grey]) -> None:
    collection = PictureCollection(CHESSBOARD)
    collection.add("first", pictures[0])
    small = np.asarray(cv2.resize(pictures[1], None, fx=0.75, fy=0.75))
    assert collection.add("small", small) == "of 480 x 360 px; most are of 640 x 480 px"
    assert list(collection.seen) == ["first"]


def test_a_soft_picture_goes_when_sharper_ones_come(pictures: list[Grey]) -> None:
    collection = PictureCollection(CHESSBOARD)
    soft = np.asarray(cv2.GaussianBlur(pictures[0], (0, 0), 1.6))
    assert collection.add("soft", soft) == ""
    for number in (1, 2, 3):
        assert collection.add(str(number), pictures[number]) == ""
    assert list(collection.seen) == ["1", "2", "3"]
