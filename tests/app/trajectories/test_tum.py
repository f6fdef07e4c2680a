import gzip

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from app.features.lab.trajectories.reading import parse_tum, read_trajectory
from app.trajectories.trajectory import Trajectory, TrajectoryError
from app.trajectories.tum_file import write_tum

ROW = "1.5 1 2 3 0 0 0 1\n"
NEXT = "2.5 1 2 3 0 0 0 1\n"

finite = st.floats(-1e3, 1e3)


@given(
    arrays(float, (5, 3), elements=finite),
    arrays(float, (5, 4), elements=st.floats(-1, 1)),
    st.floats(0, 2e9),
)
def test_what_was_written_is_read_again(tmp_path_factory, positions, quaternions, start):
    quaternions = quaternions + np.array([0, 0, 0, 2])
    written = Trajectory(start + np.arange(5) * 0.033, positions, quaternions)
    path = tmp_path_factory.getbasetemp() / "again.tum"
    write_tum(path, written)
    read = read_trajectory(path)
    np.testing.assert_allclose(read.stamps, written.stamps, rtol=1e-16, atol=1e-9)
    np.testing.assert_allclose(read.positions, written.positions, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read.quaternions, written.quaternions, rtol=0, atol=1.01e-12)


def test_comments_are_written_and_read(tmp_path):
    written = Trajectory.of_poses([0, 1], np.zeros((2, 3)))
    path = tmp_path / "truth.tum"
    write_tum(path, written, ["seed 3\nof the square", "world sim"])
    read = read_trajectory(path)
    assert read.notes == ("seed 3", "of the square", "world sim", "stamp x y z qx qy qz qw")
    assert read.source == str(path)
    assert [one.name for one in tmp_path.iterdir()] == ["truth.tum"]


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "truth.tum"
    path.write_text("old")

    def full(*_, **__):
        raise OSError("no space left")

    monkeypatch.setattr(np, "savetxt", full)
    with pytest.raises(OSError, match="no space"):
        write_tum(path, Trajectory.of_poses([0, 1], np.zeros((2, 3))))
    assert path.read_text() == "old"
    assert [one.name for one in tmp_path.iterdir()] == ["truth.tum"]


def test_stamps_that_would_be_written_alike_are_refused(tmp_path):
    close = Trajectory.of_poses([0, 1e-10, 1], np.zeros((3, 3)))
    with pytest.raises(TrajectoryError, match="less than 1e-9 s apart"):
        write_tum(tmp_path / "close.tum", close)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("separator", [" ", "\t", ",", ", ", " \t "])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_spaces_tabs_and_commas_keep_numbers_apart(separator, end):
    text = f"# a{end}{end}" + "".join(
        separator.join(row.split()) + end for row in (ROW.strip(), NEXT.strip())
    )
    trajectory = parse_tum(text.replace("\r\n", "\n").replace("\r", "\n"), "a.tum")
    np.testing.assert_array_equal(trajectory.stamps, [1.5, 2.5])
    np.testing.assert_array_equal(trajectory.positions[1], [1, 2, 3])


def test_other_line_ends_a_mark_of_utf8_and_gzip_are_read(tmp_path):
    text = ("\ufeff# a\r\n" + ROW + NEXT).replace("\n", "\r\n").encode()
    plain, packed = tmp_path / "a.tum", tmp_path / "a.tum.gz"
    plain.write_bytes(text)
    packed.write_bytes(gzip.compress(text))
    for path in (plain, packed):
        assert len(read_trajectory(path)) == 2
        assert read_trajectory(path).notes == ("a",)


def test_poses_that_bear_one_stamp_are_all_read_and_written(tmp_path):
    trajectory = parse_tum(ROW + ROW.replace("3", "4") + NEXT, "desk.txt")
    np.testing.assert_array_equal(trajectory.stamps, [1.5, 1.5, 2.5])
    np.testing.assert_array_equal(trajectory.without_repeats().positions[:, 2], [4, 3])
    path = tmp_path / "again.tum"
    write_tum(path, trajectory)
    np.testing.assert_array_equal(read_trajectory(path).positions[:, 2], [3, 4, 3])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n", r"t\.tum, line 1: 3 columns; valid are 8: stamp x y z qx qy qz qw"),
        ("# only\n", "no poses"),
        (ROW, "has 1 pose"),
        (NEXT + ROW, "line 2: stamp 1.5 follows 2.5"),
        (ROW + NEXT.replace("3", "nan"), "line 2: a number is not finite"),
        (ROW + NEXT.replace("3", "three"), "line 2: 'three' is no number"),
        (ROW + NEXT.replace("3", "1_0"), "line 2: '1_0' is no number"),
        (ROW + NEXT.replace("0 0 0 1", "0 0 0 0"), "line 2: its quaternion has no length"),
    ],
)
def test_bad_text_is_refused_with_file_and_line(text, message):
    with pytest.raises(TrajectoryError, match=message) as caught:
        parse_tum(text, "t.tum")
    assert "t.tum" in str(caught.value)
