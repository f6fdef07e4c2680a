"""What the motion model lets steps err by, and how that adds up along a drive."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motion_drives import varied_steps

from app.features.lab.model_fits.motions import chained, motions_of, relative, seen_from, twists_of
from app.features.lab.model_fits.windows import by_alpha, summed
from robot.geometry import Pose2, Twist2, compose
from robot.localization.models.odometry_motion import STANDING_M, DifferentialMotion

ALPHAS = (0.02, 0.3, 0.05, 0.002)
MODEL = DifferentialMotion(*ALPHAS)

places = st.floats(-5, 5)
headings = st.floats(-3.1, 3.1)
poses = st.tuples(places, places, headings).map(lambda values: np.array([values]))


def covariance_between(steps: np.ndarray, first: int, last: int) -> np.ndarray:
    path = chained(steps)
    whole = summed(by_alpha(path, steps), np.array([first]), np.array([last]))[0]
    to_end = seen_from(path[last])
    return to_end @ np.einsum("c,cij->ij", ALPHAS, whole) @ to_end.T


def in_end_frame(moved: Pose2, covariance: np.ndarray) -> np.ndarray:
    """A covariance of ends seen from a step's start, told in the axes of its end."""
    c, s = np.cos(moved.theta), np.sin(moved.theta)
    turned = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return turned @ covariance @ turned.T


@given(poses, poses)
def test_what_is_seen_from_a_pose_and_set_on_it_is_the_same_again(start, end):
    again = compose(start, relative(start, end))
    assert np.allclose(np.sin((again - end)[:, 2]), 0, atol=1e-9)
    assert np.allclose(again[:, :2], end[:, :2], atol=1e-9)


@given(st.tuples(places, places, headings), st.floats(0, 1))
def test_a_twist_and_its_motion_tell_the_same(values, size):
    motions = size * np.array([values])
    assert np.allclose(motions_of(twists_of(motions)), motions, atol=1e-9)
    # A twist kept half as long, twice.
    half = motions_of(twists_of(motions) / 2)
    assert np.allclose(compose(half, half)[:, :2], motions[:, :2], atol=1e-9)


@given(poses, st.tuples(places, places, headings))
def test_a_twist_seen_from_elsewhere_moves_the_same_body(pose, values):
    twist = 1e-6 * np.array([values])
    told_there = (seen_from(pose) @ twist[..., None])[..., 0]
    assert np.allclose(
        compose(motions_of(twist), pose), compose(pose, motions_of(told_there)), atol=1e-9
    )


@pytest.mark.parametrize(
    "twist",
    [
        Twist2(0.15, 0.8),
        Twist2(-0.15, 0.5),
        Twist2(0.15, 0.0),
        Twist2(-0.3, 0.0),
        Twist2(0.0, -1.2),
        Twist2(0.9 * STANDING_M * 30, 0.9),
        Twist2(1.1 * STANDING_M * 30, 0.9),
    ],
)
def test_one_step_errs_as_the_motion_model_says(twist):
    moved = twist.integrate(1 / 30)
    expected = in_end_frame(moved, MODEL.moments(moved)[1])
    assert np.allclose(
        covariance_between(moved.to_array()[None], 0, 1), expected, rtol=1e-9, atol=1e-18
    )


def test_many_steps_err_as_particles_spread():
    steps, rng = varied_steps(12.0), np.random.default_rng(0)
    particles = np.zeros((20_000, 3))
    for moved in steps:
        particles = MODEL.sample(particles, moved, rng)
    along = np.array([moved.to_array() for moved in steps])
    end = np.broadcast_to(chained(along)[-1], particles.shape)
    spread = np.cov(twists_of(relative(end, particles)).T)
    predicted = covariance_between(along, 0, len(steps))
    sizes = np.sqrt(np.diag(predicted))
    assert np.allclose(
        spread / np.outer(sizes, sizes), predicted / np.outer(sizes, sizes), atol=0.05
    )


def test_a_window_in_a_drive_errs_as_that_window_alone():
    steps = np.array([moved.to_array() for moved in varied_steps(8.0)])
    whole, alone = covariance_between(steps, 70, 200), covariance_between(steps[70:200], 0, 130)
    assert np.allclose(whole, alone, rtol=1e-9, atol=1e-15)


def test_poses_along_steps_are_chained():
    steps = varied_steps(5.0)
    pose = Pose2()
    for moved in steps:
        pose = pose @ moved
    last = chained(np.array([moved.to_array() for moved in steps]))[-1]
    assert Pose2.from_array(last).distance_to(pose) < 1e-12
    assert abs(Pose2.from_array(last).turn_to(pose)) < 1e-12
