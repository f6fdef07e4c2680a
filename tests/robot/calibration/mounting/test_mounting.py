"""The camera's mounting is known from one picture of a board, or of tape, on the floor."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
from board_pictures import CHARUCO, CHESSBOARD
from floor_boards import PLACED, SPEC, built, floor, seen_by
from mounting_pictures import CORNER, SQUARE, tape_picture
from places import SHARED

from robot.calibration.lens.adjustment import board_pose, fit_pose
from robot.calibration.lens.board import Board
from robot.calibration.lens.board_search import find_board
from robot.calibration.lens.sighting import Grey
from robot.calibration.mounting.board_mounting import check_scale, mounting_by_board
from robot.calibration.mounting.mounting import UNITS, LensDoubt, Mounting, MountingError
from robot.calibration.mounting.tape_mounting import mounting_by_tape
from robot.camera import FloorView, Lens
from robot.description.spec import RobotSpec
from robot.fields.floor_picture import FloorPicture
from robot.geometry import Array, Pose2
from robot.scanning.line_scanner import LineScannerSettings

pytestmark = pytest.mark.slow

DESCRIBED = SPEC.robot_from_camera
SCANNER = LineScannerSettings()


@cache
def below(board: Board, tape: float | None = None, scale: float = 1.0) -> FloorPicture:
    return floor(board, tape=tape, scale=scale)


def errors(mounting: Mounting, spec: RobotSpec) -> tuple[Array, Array]:
    """Errors and standard deviations, as people read them [degree, mm]."""
    true = replace(mounting, robot_from_camera=spec.robot_from_camera).values
    scales = np.array([scale for _, scale in UNITS.values()])
    off = [mounting.values[name] - true[name] for name in UNITS]
    return np.array(off) * scales, np.array(list(mounting.sd.values())) * scales


def by_board(spec: RobotSpec, board: Board, seed: int) -> tuple[Grey, Mounting]:
    grey = seen_by(spec, below(board), seed)
    seen = find_board(grey, board)
    return grey, mounting_by_board(spec.lens, seen, board, PLACED, DESCRIBED)


@pytest.mark.parametrize("board", [CHESSBOARD, CHARUCO], ids=lambda board: board.kind)
@pytest.mark.parametrize("seed", range(5))
def test_a_board_on_the_floor_tells_pitch_and_height(board: Board, seed: int) -> None:
    spec = built(seed)
    _, mounting = by_board(spec, board, seed)
    off, sd = errors(mounting, spec)
    assert np.abs(off[:3]).max() < 0.05
    assert np.abs(off[3:]).max() < 0.3
    assert (np.abs(off) < 4 * sd).all()


def test_the_place_is_known_no_better_than_the_board_was_laid() -> None:
    _, mounting = by_board(built(0), CHESSBOARD, 0)
    assert 0.001 < mounting.sd["x"] < 0.0015
    assert math.radians(0.29) < mounting.sd["yaw"] < math.radians(0.32)
    assert mounting.sd["pitch"] < math.radians(0.03)
    assert mounting.sd["height"] < 0.0002


def test_what_the_lens_is_known_to_is_part_of_it() -> None:
    """Principal point: 2 px of 530 turn the camera by so much; a lens 1 % longer is 1 % higher."""
    spec = built(0)
    seen = find_board(seen_by(spec, below(CHESSBOARD), 0), CHESSBOARD)

    def measure(lens: Lens) -> Mounting:
        return mounting_by_board(lens, seen, CHESSBOARD, PLACED, DESCRIBED)

    exact = measure(spec.lens)
    aside = LensDoubt(0.0, (2.0, 2.0)).added(measure, spec.lens)
    assert aside.sd["pitch"] == pytest.approx(2 / 530, rel=0.3)
    vague = LensDoubt(0.01).added(measure, spec.lens)
    longer = replace(spec.lens, matrix=spec.lens.matrix * [[1.01, 1, 1], [1, 1.01, 1], [1, 1, 1]])
    moved = measure(longer).values["height"] - exact.values["height"]
    assert vague.sd["height"] == pytest.approx(math.hypot(moved, exact.sd["height"]), rel=0.05)
    assert vague.values == exact.values


def test_a_tape_seen_through_a_vague_lens_tells_less() -> None:
    spec = built(0)
    grey = tape_picture(spec, 0)

    def measure(lens: Lens) -> Mounting:
        return mounting_by_tape(lens, grey, SQUARE, CORNER, DESCRIBED, SCANNER)

    exact, vague = measure(spec.lens), LensDoubt(0.01).added(measure, spec.lens)
    assert vague.sd["height"] > 3 * exact.sd["height"]


@pytest.mark.parametrize("placed", [Pose2(0.25, 0.15, -math.pi / 2), Pose2(0.44, 0.13, math.pi)])
def test_a_board_may_lie_turned(placed: Pose2) -> None:
    spec = built(1)
    grey = seen_by(spec, floor(CHESSBOARD, placed), 1)
    seen = find_board(grey, CHESSBOARD)
    mounting = mounting_by_board(spec.lens, seen, CHESSBOARD, placed, DESCRIBED)
    off, _ = errors(mounting, spec)
    assert np.abs(off[:3]).max() < 0.05 and np.abs(off[3:]).max() < 0.3


def test_a_board_that_lies_otherwise_is_refused() -> None:
    spec = built(1)
    seen = find_board(seen_by(spec, below(CHARUCO), 1), CHARUCO)
    with pytest.raises(MountingError, match=r"turned by 9\d degrees against its description"):
        mounting_by_board(spec.lens, seen, CHARUCO, Pose2(0.2, 0.1, math.pi / 2), DESCRIBED)


def test_another_lens_is_refused() -> None:
    spec = built(1)
    seen = find_board(seen_by(spec, below(CHESSBOARD), 1), CHESSBOARD)
    bent = replace(spec.lens, distortion=np.array([-0.4, 0.2, 0, 0, 0]))
    with pytest.raises(MountingError, match="px off a flat board seen through this lens"):
        mounting_by_board(bent, seen, CHESSBOARD, PLACED, DESCRIBED)


@pytest.mark.parametrize(("scale", "squares"), [(0.96, 24.0), (1.04, 26.0)])
def test_a_board_printed_at_another_scale_is_told_by_the_tape(scale: float, squares: float) -> None:
    spec = built(3)
    grey = seen_by(spec, below(CHESSBOARD, 0.05, scale), 3)
    seen = find_board(grey, CHESSBOARD)
    mounting = mounting_by_board(spec.lens, seen, CHESSBOARD, PLACED, DESCRIBED)
    with pytest.raises(MountingError, match="the tape seems") as refused:
        check_scale(grey, spec.lens, mounting, seen, CHESSBOARD, SCANNER)
    told = str(refused.value).split("the squares are not 25.00 mm but ")[1]
    assert float(told.split()[0]) == pytest.approx(squares, abs=0.1)


@pytest.mark.parametrize(("tape", "width"), [(0.05, 0.05), (None, None)])
def test_a_board_printed_at_its_scale_passes(tape: float | None, width: float | None) -> None:
    spec = built(3)
    grey = seen_by(spec, below(CHESSBOARD, tape), 3)
    seen = find_board(grey, CHESSBOARD)
    mounting = mounting_by_board(spec.lens, seen, CHESSBOARD, PLACED, DESCRIBED)
    measured = check_scale(grey, spec.lens, mounting, seen, CHESSBOARD, SCANNER)
    assert measured == (None if width is None else pytest.approx(width, abs=0.0005))


def by_tape(spec: RobotSpec, grey: Grey, told: Pose2 = CORNER) -> Mounting:
    return mounting_by_tape(spec.lens, grey, SQUARE, told, DESCRIBED, SCANNER)


@pytest.mark.parametrize("seed", range(5))
def test_a_corner_of_tape_tells_the_mounting(seed: int) -> None:
    spec = built(seed)
    off, sd = errors(by_tape(spec, tape_picture(spec, seed)), spec)
    assert np.abs(off[:3]).max() < 0.08
    assert np.abs(off[3:]).max() < 0.5
    assert (np.abs(off) < 4 * sd).all()


def test_what_a_single_strip_does_not_tell_has_a_wide_interval() -> None:
    spec, ahead = built(2), SQUARE.start
    corner = by_tape(spec, tape_picture(spec, 2))
    mounting = by_tape(spec, tape_picture(spec, 2, ahead), ahead)
    off, sd = errors(mounting, spec)
    assert (np.abs(off) < 4 * sd).all()
    assert mounting.sd["pitch"] > 3 * corner.sd["pitch"]


@pytest.mark.parametrize("told", [Pose2(0.1, -0.1, 1.4), Pose2(0.25, 0.2, 0.85)], ids=str)
def test_a_robot_that_stands_elsewhere_is_refused(told: Pose2) -> None:
    spec = built(1)
    with pytest.raises(MountingError, match="the robot does not stand where --start says"):
        by_tape(spec, tape_picture(spec, 1), told)


def test_a_picture_without_tape_is_refused() -> None:
    with pytest.raises(MountingError, match="0 edges of tape in sight; valid are 30 or more"):
        by_tape(SPEC, np.full((480, 640), 200, np.uint8))


@pytest.mark.data
@pytest.mark.skipif(not SHARED.exists(), reason="needs the recordings beside the repository")
def test_a_real_robots_camera_looks_where_it_was_measured_to_look() -> None:
    """Published: the principal ray meets the floor 0.40 m ahead, to 3 cm; the lens is given."""
    matrix = np.array([[295.796, 0, 321.262], [0, 299.539, 241.736], [0, 0, 1]])
    lens = Lens(640, 480, matrix, np.array([-0.235440, 0.036378, -0.003307, -0.001214, 0]))
    board, placed = Board("chessboard", 8, 6, 0.031), Pose2(0.160, -0.124)
    grey = cv2.imread(str(SHARED / "duckietown_floor" / "image1.jpg"), cv2.IMREAD_GRAYSCALE)
    seen = find_board(np.asarray(grey, np.uint8), board)
    mounting = mounting_by_board(lens, seen, board, placed, DESCRIBED)
    view = FloorView(lens, mounting.robot_from_camera)
    assert np.linalg.norm(view.floor_points(matrix[:2, 2][None])[0] - (0.40, 0)) < 0.03
    on_floor = view.floor_points(seen.pixels)
    expected = placed.apply(board.corners[seen.ids, :2])
    assert np.linalg.norm(on_floor - expected, axis=1).mean() < 0.0023


@pytest.mark.data
@pytest.mark.skipif(not SHARED.exists(), reason="needs the recordings beside the repository")
def test_opencvs_charuco_board_is_where_opencv_has_it() -> None:
    """24 corners, t = (-0.0912, -0.1891, 0.3987) m from OpenCV's corner, 0.216 px."""
    folder = SHARED / "charuco_aruco_opencv"
    file = cv2.FileStorage(str(folder / "tutorial_camera_charuco.yml"), cv2.FILE_STORAGE_READ)
    matrix, bends = (
        file.getNode(name).mat() for name in ("camera_matrix", "distortion_coefficients")
    )
    lens = Lens(640, 480, matrix, bends.ravel())
    board = Board("charuco", 5, 7, 0.04, 0.5, "6x6_250")
    grey = cv2.imread(str(folder / "choriginal.jpg"), cv2.IMREAD_GRAYSCALE)
    seen = find_board(np.asarray(grey, np.uint8), board)
    assert len(seen.ids) == 24
    fit = fit_pose(lens, seen, board, board_pose(lens, seen, board))
    # OpenCV's origin is the upper left corner of the page.
    upper_left = np.array([board.rows, board.columns, 0]) * board.square
    place = cv2.Rodrigues(fit.pose[:3])[0] @ upper_left + fit.pose[3:]
    assert place == pytest.approx([-0.0912, -0.1891, 0.3987], abs=0.0003)
    assert math.sqrt((fit.errors**2).sum(axis=1).mean()) < 0.22
