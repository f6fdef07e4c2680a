import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from app.features.lab.trajectories.association import associate, at
from app.trajectories.trajectory import Trajectory, TrajectoryError


def line(stamps, source=""):
    """Goes along x at 1 m/s and turns by 0.5 rad/s."""
    stamps = np.asarray(stamps, dtype=float)
    poses = np.column_stack([stamps, 0 * stamps, 0.5 * stamps])
    return Trajectory.of_poses(stamps, poses, source)


def test_each_pose_of_the_shorter_has_the_nearest_of_the_longer():
    truth, estimate = line(np.arange(0, 10, 0.01)), line([0.004, 1.007, 5.0, 9.992, 20.0])
    true, found = associate(truth, estimate)
    np.testing.assert_allclose(true.positions[:, 0], [0, 1.01, 5, 9.99])
    np.testing.assert_allclose(found.positions[:, 0], [0.004, 1.007, 5, 9.992])
    np.testing.assert_array_equal(true.stamps, found.stamps)


def test_of_two_equally_near_the_earlier_counts():
    true, _ = associate(line([0, 1, 2, 3, 4]), line([0.5, 1.5, 2.5]), 0.5)
    np.testing.assert_array_equal(true.positions[:, 0], [0, 1, 2])


def test_the_longer_may_be_the_truth_or_the_estimate():
    few, many = line([0, 1, 2, 3]), line(np.arange(0, 3.01, 0.1))
    for truth, estimate in ((few, many), (many, few)):
        true, found = associate(truth, estimate)
        assert len(true) == len(found) == 4
        np.testing.assert_allclose(true.positions, found.positions, atol=1e-12)


def test_one_pose_may_stand_in_several_pairs():
    truth, estimate = line(np.arange(0, 100, 1.0)), line(np.arange(10, 12, 0.1))
    true, _ = associate(truth, estimate, 0.25)
    np.testing.assert_array_equal(np.unique(true.positions[:, 0]), [10, 11, 12])
    assert len(true) > 5


def test_times_that_do_not_overlap_are_told():
    with pytest.raises(TrajectoryError, match="do not overlap in time") as caught:
        associate(line([0, 1, 2], "truth.tum"), line([0, 3], "amcl.tum").shifted(1e9))
    for part in ("truth.tum (from 0.000 to 2.000 s)", "amcl.tum (from 1000000000.000 to"):
        assert part in str(caught.value)


def test_too_few_pairs_are_told():
    with pytest.raises(
        TrajectoryError, match=r"t\.tum .* and e\.tum .* have 2 pairs .* valid are 3"
    ):
        associate(line([0, 1, 2, 3], "t.tum"), line([0, 1, 2.5], "e.tum"))
    with pytest.raises(TrajectoryError, match="have no pairs"):
        associate(line([0, 1, 2, 3]), line([0.5, 1.5, 2.5]))


@given(st.lists(st.floats(0, 10), min_size=2, max_size=20, unique=True).map(sorted))
def test_between_poses_it_is_on_the_line_and_turns_evenly(stamps):
    stamps = np.unique(np.round(stamps, 6))
    if len(stamps) < 2:
        return
    found, known = at(line(np.arange(0, 10.01, 0.1)), stamps)
    assert known.all()
    np.testing.assert_allclose(found.positions[:, 0], stamps, atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * found.poses[:, 2]), np.exp(0.5j * stamps), atol=1e-9)


def test_rotations_go_the_short_way_whatever_the_signs_of_quaternions():
    turns = Rotation.from_euler("xyz", [[0.1, 0.2, 3.0], [0.1, 0.2, -3.0]]).as_quat()
    for sign in (1, -1):
        path = Trajectory([0, 1], np.zeros((2, 3)), turns * [[1], [sign]])
        halfway, _ = at(path, [0.25, 0.5], max_gap=1)
        middle = Rotation.from_quat(halfway.quaternions[1])
        off = [(middle.inv() * Rotation.from_quat(turn)).magnitude() for turn in turns]
        whole = Rotation.from_quat(turns[0]).inv() * Rotation.from_quat(turns[1])
        np.testing.assert_allclose(off, whole.magnitude() / 2)


def test_off_the_ends_and_in_gaps_nothing_is_known():
    path = line([0, 0.1, 0.2, 2, 2.1])
    asked = [-0.1, 0, 0.15, 0.2, 1.0, 2, 2.05, 2.1, 2.2]
    found, known = at(path, asked, max_gap=0.5)
    np.testing.assert_array_equal(known, [0, 1, 1, 1, 0, 1, 1, 1, 0])
    np.testing.assert_allclose(found.stamps, np.array(asked)[known])
    with pytest.raises(
        TrajectoryError, match=r"t\.tum \(from 0.000 to 1.000 s\) has poses at 0 of"
    ):
        at(line([0, 1], "t.tum"), [5, 6])
