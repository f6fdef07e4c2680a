"""What a calibration leaves open is all that the monitor expects to find."""

import numpy as np
import pytest

from robot.description.unknowns import NAMES, PRIORS, ROBOT
from robot.localization.monitoring.odometry_check import ERRORS
from robot.localization.monitoring.steady_errors import CHANGED, UNCALIBRATED, SteadyErrors


def test_a_calibrated_robot_errs_less_than_a_drawn_one() -> None:
    errors = SteadyErrors.calibrated(0.01 * PRIORS[:ROBOT], track=0.12)
    drawn = SteadyErrors()
    assert (errors.odometry < drawn.odometry).all()
    assert (errors.odometry >= CHANGED).all()
    assert (errors.mounting[:2] < drawn.mounting[:2]).all()
    assert errors.mounting[2] == drawn.mounting[2]  # the map is no part of the robot
    assert (errors.measured > 0).all() and not drawn.measured.any()


def test_what_was_not_measured_errs_as_before() -> None:
    errors = SteadyErrors.calibrated(PRIORS[:ROBOT], track=0.12)
    assert errors.odometry == pytest.approx(UNCALIBRATED)


def test_each_number_is_of_its_error() -> None:
    for name, error in (
        ("picture_delay", "late"),
        ("wheel_separation", "turn"),
        ("camera_x", "ahead"),
        ("camera_y", "aside"),
        ("camera_yaw", "yaw"),
    ):
        sd = np.zeros(ROBOT)
        sd[NAMES.index(name)] = 1e-2 * UNCALIBRATED[ERRORS.index(error)]
        wide = SteadyErrors.calibrated(sd, track=0.12).odometry
        assert np.flatnonzero(wide > CHANGED).tolist() == [ERRORS.index(error)]
