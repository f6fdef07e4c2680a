"""Steps that err more than a motion model says."""

from __future__ import annotations

import numpy as np
import pytest

from robot.geometry import Pose2, compose, mean_pose, pose_covariance, wrap_angle
from robot.localization.models.motion_models import LoosenedMotion, loosened
from robot.localization.models.odometry_motion import DifferentialMotion

MODEL = DifferentialMotion(0.02, 0.01, 0.01, 0.001)
STEPS = [Pose2(0.1, 0, 0), Pose2(0.05, 0.01, 0.4), Pose2(-0.04, 0, -0.2), Pose2(0, 0, 0.7)]


@pytest.mark.parametrize("moved", STEPS, ids=str)
@pytest.mark.parametrize("factor", [1.5, 4.0])
def test_standard_deviations_are_so_many_times_wider_and_the_mean_stays(
    moved: Pose2, factor: float
) -> None:
    mean, covariance = MODEL.moments(moved)
    wide_mean, wide = loosened(MODEL, factor).moments(moved)
    assert wide_mean == mean
    np.testing.assert_allclose(wide, factor**2 * covariance)


@pytest.mark.parametrize("moved", STEPS, ids=str)
def test_what_is_drawn_is_as_wide_as_it_says(moved: Pose2) -> None:
    count, factor = 40_000, 1.5
    start = np.array([0.2, -0.1, 3.1])
    drawn = LoosenedMotion(MODEL, factor).sample(
        np.tile(start, (count, 1)), moved, np.random.default_rng(0)
    )
    assert (np.abs(drawn[:, 2]) <= np.pi).all()
    even = np.full(count, 1 / count)
    mean = mean_pose(drawn, even)
    wanted, covariance = loosened(MODEL, factor).moments(moved)
    there = Pose2.from_array(start) @ wanted
    # Turns bend what lies ahead; the moments are those of small errors.
    assert mean.distance_to(there) < 0.002 and abs(mean.turn_to(there)) < 0.003
    local = compose(np.tile(Pose2.from_array(start).inverse().to_array(), (count, 1)), drawn)
    found = pose_covariance(local, even, mean_pose(local, even))
    sds = np.sqrt(np.diag(covariance))
    np.testing.assert_allclose(
        found / np.outer(sds + 1e-9, sds + 1e-9), covariance / np.outer(sds + 1e-9, sds + 1e-9),
        atol=0.1,
    )  # fmt: skip


def test_each_draw_is_that_of_the_model_farther_from_the_mean() -> None:
    moved, poses = Pose2(0.05, 0.01, 0.4), np.tile([0.0, 0.0, 3.0], (50, 1))
    plain = MODEL.sample(poses, moved, np.random.default_rng(1))
    wide = LoosenedMotion(MODEL, 3.0).sample(poses, moved, np.random.default_rng(1))
    mean = compose(poses, moved.to_array())
    np.testing.assert_allclose(wide[:, :2] - mean[:, :2], 3 * (plain[:, :2] - mean[:, :2]))
    np.testing.assert_allclose(
        wrap_angle(wide[:, 2] - mean[:, 2]), wrap_angle(3 * wrap_angle(plain[:, 2] - mean[:, 2]))
    )


def test_a_factor_of_one_is_the_model_itself() -> None:
    assert loosened(MODEL, 1.0) is MODEL
