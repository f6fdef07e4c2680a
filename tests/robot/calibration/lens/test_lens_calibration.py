"""A lens is known from pictures of a board; pictures of no use are refused with the reason."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
import pytest
from board_pictures import CHARUCO, CHESSBOARD, lens_of, picture, pose, poses

from robot.calibration.lens.board import Board
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.lens_calibration import LensError, calibrate_lens
from robot.calibration.lens.sighting import Grey, Sighting, SightingError

pytestmark = pytest.mark.slow


@cache
def pictures(board: Board, model: str, count: int = 12, seed: int = 0) -> tuple[Grey, ...]:
    rng = np.random.default_rng(seed)
    lens = lens_of(model)
    return tuple(picture(board, place, rng, model) for place in poses(board, lens, count, rng))


@cache
def sightings(board: Board, model: str) -> dict[str, Sighting]:
    seen = (find_board(grey, board) for grey in pictures(board, model))
    return {f"{number:02}": sighting for number, sighting in enumerate(seen)}


CASES = [
    (CHESSBOARD, "plumb_bob"),
    (CHESSBOARD, "rational_polynomial"),
    (CHESSBOARD, "equidistant"),
    (CHARUCO, "plumb_bob"),
]


@pytest.mark.parametrize(("board", "model"), CASES, ids=str)
def test_the_lens_is_known_where_the_boards_were(board: Board, model: str) -> None:
    """Focal length and principal point within their intervals, pixels within one."""
    result = calibrate_lens(sightings(board, model), board, {})
    true = lens_of(model)
    assert result.chosen.rms < 0.15
    errors = (
        result.lens.matrix[[0, 1, 0, 1], [0, 1, 2, 2]] - true.matrix[[0, 1, 0, 1], [0, 1, 2, 2]]
    )
    if result.lens.model == model:
        assert (np.abs(errors) < 4 * result.chosen.fit.sd[:4]).all()
    middle = np.stack(np.meshgrid(np.linspace(80, 560, 9), np.linspace(60, 420, 7)), axis=-1)
    pixels = middle.reshape(-1, 2)
    assert np.abs(result.lens.project(true.unproject(pixels)) - pixels).max() < 1.0


def test_the_simplest_model_that_is_good_enough_is_chosen() -> None:
    result = calibrate_lens(sightings(CHESSBOARD, "plumb_bob"), CHESSBOARD, {})
    assert result.lens.model == "plumb_bob"
    assert list(result.lens.parameters) == ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"]
    fits = {rating.model: rating.fit.rms for rating in result.ratings}
    assert fits["rational_polynomial"] < 1.001 * fits["plumb_bob"]


def test_a_fisheye_needs_its_own_model() -> None:
    result = calibrate_lens(sightings(CHESSBOARD, "equidistant"), CHESSBOARD, {})
    held_out = {rating.model: rating.rms for rating in result.ratings}
    assert result.lens.model == "equidistant"
    assert held_out["equidistant"] < held_out["plumb_bob"]


@pytest.mark.parametrize(("board", "model"), CASES[::3], ids=str)
def test_corners_are_seen_to_a_tenth_of_a_pixel(board: Board, model: str) -> None:
    rng, lens = np.random.default_rng(0), lens_of(model)
    for place, sighting in zip(
        poses(board, lens, 12, rng), sightings(board, model).values(), strict=True
    ):
        points = board.corners @ place[:3, :3].T + place[:3, 3]
        expected = lens.project(points)[sighting.ids]
        if board.kind == "chessboard":  # which side is up is not told
            turned = expected[::-1]
            expected = min(expected, turned, key=lambda one: np.abs(one - sighting.pixels).max())
        assert np.sqrt(np.mean((sighting.pixels - expected) ** 2)) < 0.1


@cache
def still() -> Grey:
    place = pose(CHESSBOARD, lens_of(), (320, 240), 0.45, (0.4, 0.2, 0.1))
    return picture(CHESSBOARD, place, np.random.default_rng(1))


def of_charuco() -> Grey:
    return pictures(CHARUCO, "plumb_bob")[0]


def moved(grey: Grey) -> Grey:
    """A camera that moved by 11 px meanwhile."""
    streak = np.zeros((11, 11), np.float32)
    streak[5] = 1 / 11
    return np.asarray(cv2.filter2D(grey, -1, streak))


@pytest.mark.parametrize(
    ("grey", "board", "words"),
    [
        (lambda: np.full((480, 640), 128, np.uint8), CHESSBOARD, "no chessboard of 9 x 6"),
        (lambda: cv2.GaussianBlur(still(), (0, 0), 3), CHESSBOARD, "blurred: edges are"),
        (lambda: moved(still()), CHESSBOARD, "blurred: edges are"),
        (
            lambda: still()[:, :330],
            CHESSBOARD,
            "no whole chessboard of 9 x 6 inner corners, but",
        ),
        (still, Board("chessboard", 9, 7, 0.025), "more corners than 8 x 6|no whole"),
        (still, Board("chessboard", 11, 8, 0.025), "no whole chessboard of 10 x 7"),
        (still, Board("chessboard", 5, 3, 0.025), "too small to be found; valid are 3 inner"),
        (still, CHARUCO, "0 corners of the charuco board"),
        (lambda: np.fliplr(of_charuco()).copy(), CHARUCO, "mirrored"),
        (
            of_charuco,
            Board("charuco", 7, 5, 0.035, dictionary="4x4_50"),
            "it shows .* markers of the dictionary 5x5",
        ),
    ],
)
def test_a_picture_of_no_use_is_refused(grey: Callable[[], Grey], board: Board, words: str) -> None:
    with pytest.raises(SightingError, match=words):
        find_board(grey(), board)


def test_a_charuco_board_may_be_cut_off() -> None:
    whole = of_charuco()
    seen = find_board(whole, CHARUCO)
    left = int(np.median(seen.pixels[:, 0]))
    part = find_board(np.ascontiguousarray(whole[:, left:]), CHARUCO)
    assert 8 <= len(part.ids) < len(seen.ids)
    for number, place in part.places.items():
        assert np.abs(place + np.array([left, 0]) - seen.places[number]).max() < 0.2


def changed(sighting: Sighting, **fields: object) -> Sighting:
    return Sighting(**{"ids": sighting.ids, "pixels": sighting.pixels, "size": sighting.size,
                       "edge_width": sighting.edge_width} | fields)  # fmt: skip


def test_bad_pictures_among_good_ones_are_refused_one_by_one() -> None:
    good = sightings(CHESSBOARD, "plumb_bob")
    some = good["03"]
    flipped = some.mirrored(CHESSBOARD)
    zoomed = lens_of(scale=1.3)
    rng = np.random.default_rng(7)
    place = poses(CHESSBOARD, zoomed, 1, rng)[0]
    other = find_board(picture(CHESSBOARD, place, rng, scale=1.3), CHESSBOARD)
    bad = {
        "repeated": (changed(some, pixels=some.pixels + 0.5), "repeated: the board is where it is"),
        "small": (changed(some, size=(320, 240), pixels=some.pixels / 2), "of 320 x 240 px; most"),
        "soft": (changed(good["05"], edge_width=5.5), "blurred: edges are 5.5 px wide, in the oth"),
        "mirrored": (flipped, "mirrored: turned round, it is 03"),
        "zoomed": (other, "px off a lens that fits the others"),
    }
    told = good | {name: sighting for name, (sighting, _) in bad.items()}
    result = calibrate_lens(told, CHESSBOARD, {"early": "no picture"})
    assert set(result.refused) == {*bad, "early"}
    assert list(result.seen) == list(good)
    for name, (_, words) in bad.items():
        assert words in result.refused[name]


def test_too_few_pictures_are_refused_with_what_was_wrong() -> None:
    few = dict(list(sightings(CHESSBOARD, "plumb_bob").items())[:4])
    with pytest.raises(LensError, match=r"4 pictures of 5 .* 6 or more \(a: blurred\)"):
        calibrate_lens(few, CHESSBOARD, {"a": "blurred"})
