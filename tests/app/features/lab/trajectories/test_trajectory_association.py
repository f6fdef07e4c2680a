import numpy as np
import pytest

from app.features.lab.trajectories.association import associate
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
