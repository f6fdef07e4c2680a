"""The report of a calibration by driving."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from calibrations import SPEC, SQUARE, START_COVARIANCE, driven, placed

from app.features.lab.calibrate.calibrated_robot import CalibratedRobot
from app.features.lab.calibrate.drive_report import drive_report, mean_errors
from robot.calibration.calibrate import calibrate

pytestmark = pytest.mark.slow

SEED = 530


def test_it_shows_what_was_measured_and_what_does_not_fit() -> None:
    log = driven("hand-built", SEED, 15.0)[0]
    lens = replace(SPEC.lens, distortion=1.15 * SPEC.lens.distortion)
    spec = SPEC.with_camera(lens, SPEC.robot_from_camera)
    calibration = calibrate(log, spec, SQUARE, placed(SEED), START_COVARIANCE)
    result = CalibratedRobot(spec, calibration, SQUARE, log.stamps, "15 s of driving on square")
    report = drive_report(result)
    assert report.count("data:image/svg+xml;base64,") == 4
    assert "<td>camera pitch</td>" in report
    assert "not learnt" in report, "in so short a time the wheels are not"
    assert "the lens file does not fit" in report
    assert "15 s of driving on square" in report
    places, errors = mean_errors(result)
    outward = places - lens.matrix[:2, 2]
    outward /= np.hypot(*outward.T)[:, None]
    assert np.abs((errors * outward).sum(axis=1)).max() > 0.1
