import gzip

import numpy as np
import pytest
from costs import processor_seconds
from hypothesis import strategies as st
from places import SHARED

from app.features.lab.trajectories.mrclam import integrated, parse_mrclam
from app.features.lab.trajectories.reading import parse_trajectory, read_trajectory
from app.trajectories.trajectory import TrajectoryError
from robot.geometry import Pose2, Twist2

RECORDED = SHARED / "mrclam"
TRUTH = "# Time [s]    x [m]    y [m]    orientation [rad]\n"
ODOMETRY = "# Time [s]    forward velocity [m/s]    angular velocity[rad/s]\n"
TUM = "0 1 2 3 0 0 0 1\n1 1 2 3 0 0 0 1\n"
MOTIVE = (
    "Format Version,1.23,Rotation Type,Quaternion,Length Units,Meters\n\n"
    ",Type,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n"
    ",Name,R,R,R,R,R,R,R\n,ID,1,1,1,1,1,1,1\n"
    ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position\n"
    "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z\n0,0,0,0,0,1,1,2,3\n1,0.01,0,0,0,1,1,2,3.5\n"
)


def test_the_content_tells_the_form():
    assert parse_trajectory(TUM, "a").stamps[1] == 1
    assert parse_trajectory(TRUTH + "0 \t 1 \t 2 \t 0.5\n3 1 2 0.5\n", "a").positions[1, 1] == 2
    assert parse_trajectory(ODOMETRY + "0 1 0\n3 1 0\n", "a").poses[1, 0] == 3
    assert parse_trajectory(MOTIVE, "a").positions[1] == pytest.approx([1, -3.5, 2])


def test_any_form_may_be_compressed(tmp_path):
    for name, text in (("a", TUM), ("b", TRUTH + "0 1 2 0\n1 1 2 0\n"), ("c", MOTIVE)):
        path = tmp_path / name
        path.write_bytes(gzip.compress(text.encode()))
        assert len(read_trajectory(path)) == 2


def test_velocities_hold_until_the_next_line_along_arcs():
    rng = np.random.default_rng(3)
    stamps = np.cumsum(rng.uniform(0.01, 0.5, 50))
    velocities = rng.normal(size=(50, 2))
    velocities[::7, 1] = 0
    pose, expected = Pose2(), [Pose2()]
    for duration, (v, omega) in zip(np.diff(stamps), velocities, strict=False):
        pose = pose @ Twist2(v, omega).integrate(duration)
        expected.append(pose)
    found = integrated(stamps, *velocities.T)
    np.testing.assert_allclose(found[:, :2], [(p.x, p.y) for p in expected], atol=1e-12)
    np.testing.assert_allclose(
        np.cos(found[:, 2] - [p.theta for p in expected]), np.ones(50), atol=1e-12
    )


def test_of_odometry_with_one_stamp_the_last_counts():
    text = ODOMETRY + "0 1 0\n1 9 9\n1 9 9\n1 2 0\n3 0 0\n"
    found = parse_mrclam(text, "odometry.dat")
    np.testing.assert_array_equal(found.stamps, [0, 1, 3])
    np.testing.assert_allclose(found.positions[:, 0], [0, 1, 5])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (TUM[:16], "a.txt has 1 pose"),
        ("# nothing\n", "a.txt has no poses; valid are TUM text"),
        (",,\n", "a.txt, line 1: '' is no number|1 columns|0 columns"),
        ("time,x,y\n1,2,3\n", "a.txt, line 1: the header has none of z, none of qx"),
        ("name,a,b\n1,2,3\n", "a.txt, line 1: 'name' is no number; valid are TUM .* Motive.*MRCL"),
        ("1 2 3\n", "a.txt, line 1: 3 columns; valid are 8: stamp x y z"),
        (TRUTH + "0 1 2 0\n1 1 2\n", "a.txt, line 3: 3 columns; valid are 4: time x y orientation"),
        (TRUTH + "0 1 2 0\n1 1 2 inf\n", "a.txt, line 3: a number is not finite"),
        (TRUTH + "0 1 2 0\n0 1 2 0\n", "a.txt, line 3: stamp 0 is repeated"),
        (ODOMETRY + "0 1 0\n2 1 0\n1 1 0\n", "a.txt, line 4: stamp 1 follows 2; stamps must rise"),
        (ODOMETRY + "0 1 0\n0 1 0\n2 1 nan\n", "a.txt, line 4: valid are velocities"),
        (ODOMETRY + "nan 1 0\n2 1 0\n", "a.txt, line 2: a number is not finite"),
        (ODOMETRY + "0 1 0\n0 1 0\n", "a.txt has 1 pose"),
        (ODOMETRY, "a.txt has no poses"),
    ],
)
def test_bad_text_is_refused_with_file_and_line(text, message):
    with pytest.raises(TrajectoryError, match=message):
        parse_trajectory(text, "a.txt")


def test_mrclam_text_without_its_comment_is_refused():
    with pytest.raises(TrajectoryError, match="no comment tells what it holds; valid are 'time x"):
        parse_mrclam("0 1 2 3\n", "a.dat")


def test_a_body_is_only_to_be_had_of_a_capture():
    with pytest.raises(
        TrajectoryError,
        match=r"a\.tum: only files of Motive, Vicon and Qualisys have a rigid body 'R'",
    ):
        parse_trajectory(TUM, "a.tum", "R")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"1 2 3\n\0\0\0", "line 2: not text but binary data"),
        (b"1 2 3\n\n\xff\xfe", "line 3: not UTF-8 text"),
        (b"PK\x03\x04" + bytes(40), "is a zip archive or a spreadsheet .* save it as CSV"),
        (b"\x1f\x8bnothing", "is damaged"),
        (gzip.compress(TUM.encode(), mtime=0)[:-9], "is damaged"),
        (gzip.compress(b"", mtime=0), "is empty"),
    ],
)
def test_what_is_no_text_is_refused_with_the_file(tmp_path, content, message):
    path = tmp_path / "truth.tum"
    path.write_bytes(content)
    with pytest.raises(TrajectoryError, match=message) as caught:
        read_trajectory(path)
    assert str(path) in str(caught.value)


def test_a_missing_file_and_a_folder_are_named(tmp_path):
    with pytest.raises(TrajectoryError, match=f"there is no file {tmp_path}/none"):
        read_trajectory(tmp_path / "none")
    with pytest.raises(TrajectoryError, match="is a folder"):
        read_trajectory(tmp_path)
    with pytest.raises(TrajectoryError, match="cannot be read"):
        read_trajectory("a\0b")


def parsed(text):
    try:
        assert len(parse_trajectory(text, "a.txt")) >= 2
    except TrajectoryError as error:
        assert "a.txt" in str(error)


number = st.one_of(
    st.floats().map(repr), st.integers().map(str), st.text("0123456789.-+eEinfa_ ٣", max_size=6)
)


def seconds_for(rows):
    text = "\n".join(f"{i / 100} 1 2 3 0 0 0 1" for i in range(rows))
    return processor_seconds(lambda: parse_trajectory(text, "a.txt"))


@pytest.mark.slow
def test_time_grows_with_the_length_and_no_faster():
    """Ten times the rows take ten times as long, not a hundred times: the bound is in the middle.

    Other programs push ours out of the caches, which costs up to twice the time; so the least
    disturbed one of several runs counts, and short and long runs take turns.
    """
    times = [(seconds_for(3_000), seconds_for(30_000)) for _ in range(5)]
    short, long = (min(column) for column in zip(*times, strict=True))
    assert long < 30 * short


def test_long_runs_of_one_character_take_no_time():
    runs = "#", ",", " ", '"', "1", "e", "\t,", "Format Version,", "# time orientation "
    assert processor_seconds(lambda: [parsed(one * 300_000) for one in runs]) < 5


@pytest.mark.slow
@pytest.mark.data
@pytest.mark.skipif(not RECORDED.is_dir(), reason="needs the recorded drives")
@pytest.mark.parametrize("robot", [1, 2])
def test_real_odometry_goes_where_its_robot_went(robot):
    """After a minute of some five metres and many turns; other signs or units are metres off."""
    truth = read_trajectory(RECORDED / f"ds6_Robot{robot}_Groundtruth.dat.gz")
    odometry = read_trajectory(RECORDED / f"ds6_Robot{robot}_Odometry.dat.gz")
    assert truth.planar
    assert odometry.planar
    start = odometry.stamps[0]
    ends = [
        Pose2.from_array(one.poses[np.searchsorted(one.stamps, at)])
        for one in (truth, odometry)
        for at in (start, start + 60)
    ]
    error = (ends[0].inverse() @ ends[1]).distance_to(ends[2].inverse() @ ends[3])
    assert error < 1.2


@pytest.mark.parametrize(
    ("frames", "more"), [("odom,base_link", 36 + 6 + 36), ("map", 36), ("map", 0)]
)
@pytest.mark.parametrize("cut", ["", "1700000000,5,ma", "1700000009,0"])
def test_what_ros2_topic_echo_prints_is_read(frames, more, cut):
    rows = [
        f"{1700000000 + k // 10},{k % 10 * 100_000_000},{frames},{0.1 * k},{-0.2 * k},0.0,"
        f"0.0,0.0,{np.sin(k / 20)},{np.cos(k / 20)}" + ",0.5" * more
        for k in range(30)
    ]
    found = parse_trajectory("\n".join([*rows, cut]), "odom.csv")
    np.testing.assert_allclose(found.stamps, 1.7e9 + 0.1 * np.arange(30), atol=1e-6)
    np.testing.assert_allclose(found.positions[:, 1], -0.2 * np.arange(30))
    np.testing.assert_allclose(found.quaternions[:, 3], np.cos(np.arange(30) / 20), atol=1e-9)


def test_a_printed_message_that_is_none_is_named():
    row = "1,0,map,0,0,0,0,0,0,1"
    with pytest.raises(TrajectoryError, match=r"line 2: no printed message; valid are those of"):
        parse_trajectory(f"{row}\n1,0,map,0,x\n{row}", "odom.csv")
