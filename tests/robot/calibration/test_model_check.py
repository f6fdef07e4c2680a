"""A wrong drawing or lens file is told: camera and path give way, and hide it."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from calibrations import SPEC, SQUARE, START_COVARIANCE, driven, placed

from app.settings.config import MAPS
from robot.calibration.calibrate import Calibration, calibrate
from robot.calibration.drive_log import DriveLog
from robot.calibration.model_check import strokes_of
from robot.description.spec import RobotSpec
from robot.description.unknowns import NAMES
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.geometry import Array

pytestmark = pytest.mark.slow

SEED = 530
WIDTH = NAMES.index("tape_width")


def drive() -> tuple[DriveLog, Array, Array]:
    log, true, path = driven("hand-built", SEED, 40.0)
    return log.until(200), true, path[:200]


def calibrated(spec: RobotSpec = SPEC, taped: Field = SQUARE) -> Calibration:
    return calibrate(drive()[0], spec, taped, placed(SEED), START_COVARIANCE)


def path_error(calibration: Calibration) -> float:
    distances = (calibration.solution.state.poses - drive()[2])[:, :2]
    seen = np.bincount(calibration.solution.misses.picture, minlength=len(distances)) > 20
    return float(np.sqrt((distances[seen] ** 2).sum(axis=1).mean()))


def redrawn(edges: Array) -> Field:
    return replace(SQUARE, edges=edges)


def test_nothing_is_told_where_all_is_as_drawn() -> None:
    assert calibrated().remarks == ()


@pytest.mark.parametrize("told", [0.049, 0.051])
def test_tape_of_another_width_is_told_and_does_no_harm(told: float) -> None:
    outer = np.abs(SQUARE.edges) > 0.5
    edges = SQUARE.edges + np.sign(SQUARE.edges) * np.where(outer, 1, -1) * (told - 0.05) / 2
    taped = replace(redrawn(edges), tape=(replace(SQUARE.tape[0], width=told),))
    calibration = calibrated(taped=taped)
    (remark,) = calibration.remarks
    assert re.match(r"the tape seems to be (49\.9|50\.0|50\.1) mm wide, not (49|51)\.0 mm", remark)
    assert abs(calibration.values[WIDTH] - (0.05 - told)) < 1e-4
    assert path_error(calibration) < 0.001


def test_a_stroke_at_the_wrong_place_is_told_with_its_place() -> None:
    edges = SQUARE.edges.copy()
    edges[:, ::2] += np.where(edges[:, ::2] > 0.4, 0.003, 0.0)
    (remark,) = calibrated(taped=redrawn(edges)).remarks
    assert "(0.50, 0.00)" in remark
    assert re.search(r" lies (2\.[89]|3\.[012]) mm beside its drawing", remark)


def test_a_lens_file_of_another_lens_is_told() -> None:
    lens = replace(SPEC.lens, distortion=1.15 * SPEC.lens.distortion)
    calibration = calibrated(SPEC.with_camera(lens, SPEC.robot_from_camera))
    overrun, remark = calibration.remarks
    assert "lens_error" in overrun
    assert calibration.quality.contradictions == (overrun,)
    assert remark.startswith("the lens file does not fit")
    assert path_error(calibration) < 0.001


@pytest.mark.parametrize(("name", "count"), [("square", 4), ("stub", 5), ("tee", 6)])
def test_a_stroke_is_all_edges_of_a_straight_piece_of_tape(name: str, count: int) -> None:
    taped = load_field(name, MAPS)
    strokes = strokes_of(taped)
    assert len(strokes) == count
    every = np.concatenate(strokes)
    assert len(np.unique(every)) == len(every)
    for stroke in strokes:
        assert np.abs(taped.normals[stroke] @ taped.normals[stroke[0]]) == pytest.approx(1.0)
