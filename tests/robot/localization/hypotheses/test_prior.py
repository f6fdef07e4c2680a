"""What was told of the start counts, carried along by odometry."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import Pose2
from robot.localization.hypotheses.start_poses import LEAST_VARIANCE, Prior
from robot.localization.models.motion_models import DifferentialMotion

TOLD = Prior(Pose2(0.1, 0.2, 3.1), np.diag(np.square([0.1, 0.05, 0.3])))


def test_the_told_pose_itself_is_as_likely_as_can_be() -> None:
    assert TOLD.log_likelihood(TOLD.pose) == 0


@pytest.mark.parametrize(("axis", "sd"), list(enumerate([0.1, 0.05, 0.3])))
def test_it_falls_as_a_normal_distribution_does(axis: int, sd: float) -> None:
    for sds in (-2.0, 1.0, 3.0):
        off = np.zeros(3)
        off[axis] = sds * math.hypot(sd, math.sqrt(LEAST_VARIANCE[axis, axis]))
        pose = Pose2.from_array(TOLD.pose.to_array() + off)
        assert TOLD.log_likelihood(pose) == pytest.approx(-0.5 * sds**2)


def test_axes_that_were_told_to_err_together_do_so() -> None:
    slanted = Prior(Pose2(), np.array([[0.01, 0.009, 0], [0.009, 0.01, 0], [0, 0, 0.1]]))
    along = slanted.log_likelihood(Pose2(0.1, 0.1))
    assert slanted.log_likelihood(Pose2(0.1, -0.1)) < 10 * along < 0


def test_a_pose_told_without_a_doubt_is_not_believed_to_the_micrometre() -> None:
    exact = Prior(Pose2(), np.zeros((3, 3)))
    assert exact.log_likelihood(Pose2(0.005)) == pytest.approx(-0.5)
    assert exact.log_likelihood(Pose2(0.05)) < -40


MOTION = DifferentialMotion(0.0004, 0.0004, 0.0001, 0.0001)


@given(st.floats(-1, 1), st.floats(-1, 1), st.floats(-3.1, 3.1))
def test_it_moves_with_the_robot(x: float, y: float, theta: float) -> None:
    step = Pose2(x, y, theta)
    moved = TOLD.moved(step, MOTION)
    assert moved.log_likelihood(TOLD.pose @ step) == pytest.approx(0, abs=1e-9)


def test_where_a_start_as_likely_would_have_led_is_as_likely() -> None:
    """A heading that is off leads aside: told wrong by one standard deviation it still is."""
    told = Prior(Pose2(), np.diag(np.square([0.05, 0.05, 0.1])))
    start = Pose2(0, 0, 0.1)
    moved = told
    for _ in range(100):
        moved = moved.moved(Pose2(0.01), MOTION)
    end = start @ Pose2(1.0)
    assert moved.log_likelihood(end) == pytest.approx(told.log_likelihood(start), abs=0.1)


def test_the_longer_the_way_the_less_it_says() -> None:
    near, far = (TOLD.moved(Pose2(way), MOTION).covariance for way in (0.1, 1.0))
    assert np.linalg.eigvalsh(near - TOLD.covariance)[-1] > 0
    assert np.trace(far) > np.trace(near)
