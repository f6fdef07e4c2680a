"""Rules that metrics must keep."""

import numpy as np
import pytest
from costs import processor_seconds
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from wandering_paths import KINDS, moved, noisy, pair, relative_errors, rigid, walk

from app.features.lab.trajectories.association import associate
from app.features.lab.trajectories.metrics import (
    absolute_errors,
    align,
    ate_rmse,
    heading_errors,
    relative_pairs,
)
from app.trajectories.trajectory import Trajectory, TrajectoryError

seeds = st.integers(0, 2**32 - 1)


@pytest.mark.parametrize("kind", KINDS)
@given(seed=seeds)
def test_errors_do_not_change_when_the_world_moves(kind, seed):
    truth, estimate, rng = pair(kind, seed)
    motion = rigid(kind, rng)
    both = moved(truth, motion), moved(estimate, motion)
    np.testing.assert_allclose(absolute_errors(*both), absolute_errors(truth, estimate), atol=1e-12)
    assert ate_rmse(*both, aligned=True) == pytest.approx(ate_rmse(truth, estimate, True))
    np.testing.assert_allclose(heading_errors(*both), heading_errors(truth, estimate), atol=1e-7)


@pytest.mark.parametrize("kind", KINDS)
@given(seed=seeds)
def test_the_aligned_error_is_the_least_and_does_not_know_the_frame(kind, seed):
    truth, estimate, rng = pair(kind, seed)
    least = ate_rmse(truth, estimate, aligned=True)
    assert least <= ate_rmse(truth, estimate) + 1e-12
    assert ate_rmse(truth, moved(estimate, rigid(kind, rng)), True) == pytest.approx(least)
    best = align(truth, estimate).apply(estimate)
    for _ in range(5):
        rotation, shift = rigid(kind, rng)
        small = Rotation.from_rotvec(rotation.as_rotvec() * 1e-3), shift * 1e-3
        assert least <= ate_rmse(truth, moved(best, small)) + 1e-12


@pytest.mark.parametrize("kind", KINDS)
@given(seed=seeds)
def test_alignment_finds_the_motion_that_was_made(kind, seed):
    truth, _, rng = pair(kind, seed)
    rotation, shift = rigid(kind, rng)
    found = align(moved(truth, (rotation, shift)), truth)
    np.testing.assert_allclose(found.rotation, rotation.as_matrix(), atol=1e-9)
    np.testing.assert_allclose(found.translation, shift, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("delta", "unit"), [(0.5, "s"), (0.3, "m"), (7, "frames")])
@given(seed=seeds)
def test_relative_errors_do_not_know_either_frame(kind, delta, unit, seed):
    truth, estimate, rng = pair(kind, seed)
    expected = relative_errors(truth, estimate, delta, unit)
    for both in (
        (truth, moved(estimate, rigid(kind, rng))),
        (moved(truth, rigid(kind, rng)), estimate),
    ):
        translation, rotation = relative_errors(*both, delta, unit)
        np.testing.assert_allclose(translation, expected[0], atol=1e-9)
        np.testing.assert_allclose(rotation, expected[1], atol=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_a_path_has_no_error_against_itself(kind):
    truth = walk(kind, np.random.default_rng(0))
    assert ate_rmse(truth, truth) == 0
    assert ate_rmse(truth, truth, aligned=True) < 1e-12
    translation, rotation = relative_errors(truth, truth, 0.1, "s")
    assert translation.max() < 1e-12
    assert rotation.max() < 1e-7


def test_heading_errors_in_the_plane_have_a_sign_and_take_the_short_way():
    truth = Trajectory.of_poses([0, 1, 2], [[0, 0, 3.1], [1, 0, 0], [2, 0, -3.1]])
    estimate = Trajectory.of_poses([0, 1, 2], [[0, 0, -3.1], [1, 0, -0.2], [2, 0, 3.1]])
    turn = 2 * np.pi - 6.2
    np.testing.assert_allclose(heading_errors(truth, estimate), [turn, -0.2, -turn])


def test_heading_errors_in_space_are_angles_of_rotations():
    truth = walk("space", np.random.default_rng(1))
    turned = Rotation.from_quat(truth.quaternions) * Rotation.from_rotvec([0.3, 0, 0])
    estimate = Trajectory(truth.stamps, truth.positions, turned.as_quat())
    np.testing.assert_allclose(heading_errors(truth, estimate), 0.3)


def nearest_by_search(along, delta, tolerance):
    """What the pairs are, one by one."""
    for i in range(len(along) - 1):
        off = np.abs(along[i + 1 :] - along[i] - delta)
        best = int(np.argmin(off))
        if off[best] <= tolerance * delta:
            yield i, i + 1 + best


@given(
    st.lists(st.sampled_from([0.0, 0.01, 0.02, 0.1, 0.5]), min_size=2, max_size=40),
    st.sampled_from([0.01, 0.1, 0.25, 1.0]),
    st.sampled_from([0.0, 0.1, 0.5]),
)
def test_pairs_along_the_way_are_the_nearest_even_where_the_robot_stands(steps, delta, tolerance):
    along = np.cumsum(steps)
    truth = Trajectory.of_poses(
        np.arange(len(along)), np.column_stack([along, 0 * along, 0 * along])
    )
    way = np.concatenate([[0], np.cumsum(np.abs(np.diff(truth.positions[:, 0])))])
    found = list(zip(*relative_pairs(truth, delta, "m", tolerance), strict=True))
    assert found == list(nearest_by_search(way, delta, tolerance))


def test_numbers_of_poses_are_exact():
    i, j = relative_pairs(walk("planar", np.random.default_rng(0)), 30, "frames")
    np.testing.assert_array_equal(i, np.arange(30))
    np.testing.assert_array_equal(j, i + 30)


@given(seed=seeds, delta=st.floats(0.02, 1.5))
def test_pairs_by_time_are_the_nearest(seed, delta):
    truth = walk("planar", np.random.default_rng(seed), 40)
    found = list(zip(*relative_pairs(truth, delta, "s"), strict=True))
    assert found == list(nearest_by_search(truth.stamps - truth.stamps[0], delta, 0.1))


def test_sixty_thousand_poses_take_less_than_a_second_a_metric():
    rng = np.random.default_rng(0)
    truth = walk("planar", rng, 60_000)
    estimate = noisy(truth, rng)
    for work in (
        lambda: ate_rmse(truth, estimate, aligned=True),
        lambda: relative_errors(truth, estimate, 1.0, "s"),
        lambda: relative_errors(truth, estimate, 0.5, "m"),
        lambda: associate(truth, estimate.selected(np.arange(0, 60_000, 2))),
    ):
        assert processor_seconds(work) < 1


def standing(n=5, where=(0.3, 0.1, 0.0)):
    return Trajectory.of_poses(np.arange(n), np.tile(where, (n, 1)), "standing.tum")


def test_what_stays_on_one_spot_cannot_be_aligned():
    going = Trajectory.of_poses(np.arange(5), np.eye(5, 3), "going.tum")
    for truth, estimate in ((standing(), going), (going, standing())):
        with pytest.raises(TrajectoryError, match=r"standing.tum .* stays on one spot"):
            align(truth, estimate)


def test_paths_without_a_direction_in_common_cannot_be_aligned():
    square = [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]]
    mirrored = [[1, 0, 0], [0, -1, 0], [-1, 0, 0], [0, 1, 0]]
    with pytest.raises(TrajectoryError, match="no direction in common"):
        align(Trajectory.of_poses(range(4), square), Trajectory.of_poses(range(4), mirrored))


@pytest.mark.parametrize("towards", [(0, 1, 0), (1, 0, 0), (-1, 0, 0), (0.6, 0, 0.8)])
def test_along_one_line_the_alignment_turns_least(towards):
    way = np.linspace(-1, 2, 9)[:, None]
    upright = np.tile([0.1, 0, 0, 1], (9, 1))
    estimate = Trajectory(np.arange(9), way * (1.0, 0, 0), upright)
    truth = Trajectory(np.arange(9), way * np.array(towards) + 3, upright)
    found = align(truth, estimate)
    np.testing.assert_allclose(absolute_errors(truth, found.apply(estimate)), 0, atol=1e-12)
    assert np.linalg.det(found.rotation) == pytest.approx(1)
    turn = Rotation.from_matrix(found.rotation).magnitude()
    assert turn == pytest.approx(np.arccos(towards[0]), abs=1e-7)


def test_unequal_lengths_and_a_delta_out_of_reach_are_refused():
    truth = walk("planar", np.random.default_rng(0))
    with pytest.raises(TrajectoryError, match="60 poses and the trajectory 59; valid are pairs"):
        ate_rmse(truth, truth.selected(np.arange(59)))
    with pytest.raises(ValueError, match="valid are positive"):
        relative_pairs(truth, 0, "s")
