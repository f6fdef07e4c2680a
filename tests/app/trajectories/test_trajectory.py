import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.trajectories.trajectory import Trajectory, TrajectoryError

STAMPS = np.array([0.0, 0.5, 2.0])
POSES = np.array([[1.0, 2.0, 0.3], [1.5, 2.0, -3.0], [2.0, -1.0, 3.1]])
UPRIGHT = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))


def changed(array, index, value):
    copy = np.array(array)
    copy[index] = value
    return copy


@given(
    st.lists(
        st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(-np.pi, np.pi)),
        min_size=2,
        max_size=20,
    )
)
def test_poses_come_back_and_are_planar(poses):
    trajectory = Trajectory.of_poses(range(len(poses)), poses)
    assert trajectory.planar
    assert len(trajectory) == len(poses)
    off = trajectory.poses - np.array(poses)
    off[:, 2] = np.angle(np.exp(1j * off[:, 2]))
    np.testing.assert_allclose(off, 0, atol=1e-14)


def test_heading_is_where_the_x_axis_points_of_a_tilted_body():
    turn_then_pitch = np.array([0.0, np.sin(0.2), 0.0, np.cos(0.2)])
    s, c = np.sin(0.5), np.cos(0.5)
    x, y, z, w = turn_then_pitch
    quaternion = [c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z]
    trajectory = Trajectory(STAMPS, np.zeros((3, 3)), np.tile(quaternion, (3, 1)))
    np.testing.assert_allclose(trajectory.poses[:, 2], 1.0)
    assert not trajectory.planar


def test_what_leaves_its_plane_is_not_planar():
    assert Trajectory(STAMPS, np.full((3, 3), 0.7), UPRIGHT).planar
    assert not Trajectory(STAMPS, changed(np.zeros((3, 3)), (1, 2), 1e-6), UPRIGHT).planar


def test_from_above_height_and_tilt_are_not_seen():
    tilted = UPRIGHT + np.array([0.01, -0.02, 0.3, 0])
    trajectory = Trajectory(STAMPS, np.arange(9.0).reshape(3, 3), tilted, "take.csv", ("a",))
    flat = trajectory.to_planar()
    assert flat.planar
    assert (flat.source, flat.notes) == ("take.csv", ("a",))
    np.testing.assert_allclose(flat.poses, trajectory.poses)
    np.testing.assert_array_equal(flat.positions[:, 2], 0)


def test_quaternions_are_brought_to_length_one():
    trajectory = Trajectory(STAMPS, np.zeros((3, 3)), UPRIGHT * 7)
    np.testing.assert_array_equal(trajectory.quaternions, UPRIGHT)


def test_arrays_are_its_own_and_read_only():
    stamps = STAMPS.copy()
    trajectory = Trajectory.of_poses(stamps, POSES)
    stamps[0] = -5
    assert trajectory.stamps[0] == 0
    for array in (trajectory.stamps, trajectory.positions, trajectory.quaternions):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_poses_are_picked_by_index_and_by_mask():
    trajectory = Trajectory.of_poses(STAMPS, POSES, "drive.tum")
    np.testing.assert_array_equal(trajectory.selected(np.array([0, 2])).stamps, [0, 2])
    picked = trajectory.selected(np.array([False, True, True]))
    np.testing.assert_allclose(picked.poses, POSES[1:])
    assert picked.source == "drive.tum"
    np.testing.assert_array_equal(trajectory.shifted(3.0).stamps, STAMPS + 3)


@pytest.mark.parametrize(
    ("stamps", "positions", "quaternions", "message"),
    [
        (STAMPS[:0], np.zeros((0, 3)), UPRIGHT[:0], r"t\.tum has no poses; valid are 2"),
        (STAMPS[:1], np.zeros((1, 3)), UPRIGHT[:1], r"t\.tum has 1 pose; valid are 2"),
        (STAMPS[::-1], np.zeros((3, 3)), UPRIGHT, "line 12: stamp 0.5 follows 2; stamps must rise"),
        (
            changed(STAMPS, 2, 0.5),
            np.zeros((3, 3)),
            UPRIGHT,
            "line 14: stamp 0.5 is repeated",
        ),
        (changed(STAMPS, 1, np.nan), np.zeros((3, 3)), UPRIGHT, "line 12: a number is not finite"),
        (STAMPS, changed(np.zeros((3, 3)), (2, 1), np.inf), UPRIGHT, "line 14: .* not finite"),
        (STAMPS, np.zeros((3, 3)), changed(UPRIGHT, (0, 3), np.nan), "line 11: .* not finite"),
        (STAMPS, np.zeros((3, 3)), changed(UPRIGHT, 1, 0), "line 12: its quaternion has no length"),
        (STAMPS * 1e18, np.zeros((3, 3)), UPRIGHT, "line 12: .* stamps are seconds"),
        (STAMPS, changed(np.zeros((3, 3)), (1, 2), 1e200), UPRIGHT, "line 12: .* are metres"),
    ],
)
def test_what_cannot_be_is_refused_with_file_and_line(stamps, positions, quaternions, message):
    with pytest.raises(TrajectoryError, match=message) as caught:
        Trajectory(stamps, positions, quaternions, "t.tum", lines=(11, 12, 14))
    assert "t.tum" in str(caught.value)


def test_without_lines_the_pose_is_named():
    with pytest.raises(TrajectoryError, match=r"the trajectory, pose 2: .* repeated"):
        Trajectory.of_poses([1.0, 1.0], POSES[:2])


def test_arrays_of_unlike_length_are_refused():
    with pytest.raises(TrajectoryError, match="shape"):
        Trajectory(STAMPS, np.zeros((2, 3)), UPRIGHT)


def test_the_first_fault_is_the_one_that_is_told():
    stamps = np.array([0.0, 0.0, np.nan])
    with pytest.raises(TrajectoryError, match="pose 2: stamp 0 is repeated"):
        Trajectory.of_poses(stamps, POSES)
