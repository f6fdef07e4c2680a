"""A pose carried over a step: mean and covariance, as in the textbook and as particles do."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from stub_drive import DEFAULTS, draw_poses

from robot.geometry import Array, Pose2, mean_pose, pose_covariance
from robot.localization.models.motion_models import follow

MOTION = DEFAULTS.motion.model()
finite = st.floats(-1, 1)
poses = st.builds(Pose2, finite, finite, st.floats(-3.14, 3.14))
roots = arrays(float, (3, 3), elements=st.floats(-0.3, 0.3))


def test_a_step_with_a_closed_form() -> None:
    """Straight ahead along x: what the heading errs by becomes y."""
    noise = np.diag([1e-6, 0.0, 1e-4])
    moved, spread = follow(Pose2(1, 2, 0), np.diag([0.01, 0.02, 0.03]), Pose2(0.5), noise)
    assert (moved.x, moved.y, moved.theta) == pytest.approx((1.5, 2, 0))
    expected = [
        [0.01 + 1e-6, 0, 0],
        [0, 0.02 + 0.5**2 * 0.03, 0.5 * 0.03],
        [0, 0.5 * 0.03, 0.03 + 1e-4],
    ]
    np.testing.assert_allclose(spread, expected, atol=1e-15)


@pytest.mark.parametrize("heading", [0.0, 0.7, -2.5])
def test_a_step_spreads_as_particles_do(heading: float) -> None:
    rng = np.random.default_rng(0)
    start, sds = Pose2(0.1, 0.2, heading), (0.01, 0.02, 0.03)
    moved = Pose2(0.2, 0.02, 0.2)
    ends = MOTION.sample(draw_poses(rng, start, sds, 100_000), moved, rng)
    end, spread = follow(start, np.diag(np.square(sds)), moved, MOTION.moments(moved)[1])
    weights = np.full(len(ends), 1 / len(ends))
    mean = mean_pose(ends, weights)
    assert mean.distance_to(end) < 0.004 and abs(mean.turn_to(end)) < 0.002
    np.testing.assert_allclose(pose_covariance(ends, weights, mean), spread, rtol=0.05, atol=3e-5)


TINY = 2.2e-311
"""Elimination divides by what is left of such numbers."""


@given(poses, roots, poses, roots)
@example(
    Pose2(),
    np.zeros((3, 3)),
    Pose2(),
    np.array([[0.1875, TINY, TINY], [0.25, TINY, TINY], [TINY, TINY, TINY]]),
)
def test_a_step_leaves_a_covariance(start: Pose2, root: Array, moved: Pose2, noise: Array) -> None:
    end, spread = follow(start, root @ root.T, moved, noise @ noise.T)
    np.testing.assert_array_equal(spread, spread.T)
    assert np.linalg.eigvalsh(spread)[0] >= -1e-12
    assert determinant(spread) >= determinant(root @ root.T) - 1e-9
    wanted = start @ moved
    assert end == wanted


def determinant(matrix: Array) -> float:
    """Of a matrix (3, 3), without a division."""
    return float(matrix[0] @ np.cross(matrix[1], matrix[2]))


def test_two_steps_in_one_are_as_wide_as_one_after_the_other() -> None:
    """Composition: so steps may be gathered and followed at once."""
    start, first, second = Pose2(0.1, 0.2, 0.3), Pose2(0.1, 0.02, 0.4), Pose2(0.05, -0.01, -0.2)
    noise = np.diag([1e-4, 2e-4, 3e-4])
    known = np.diag([0.01, 0.02, 0.03])
    one = follow(*follow(start, known, first, noise), second, noise)
    gathered = follow(*follow(Pose2(), np.zeros((3, 3)), first, noise), second, noise)
    other = follow(start, known, *gathered)
    assert one[0].distance_to(other[0]) < 1e-12
    np.testing.assert_allclose(one[1], other[1], atol=1e-15)
