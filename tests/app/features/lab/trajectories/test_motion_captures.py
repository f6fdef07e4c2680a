"""Trajectories of Vicon, Qualisys and g2o: read to the same poses, or named as what they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.features.lab.trajectories.reading import parse_trajectory, read_trajectory
from app.features.lab.trajectories.unstamped import UNDERSTOOD
from app.trajectories.trajectory import Trajectory, TrajectoryError

TIMES = np.arange(0, 8, 0.01)
PLACES = np.column_stack(
    [np.sin(TIMES), 0.5 * np.cos(0.7 * TIMES), 0.1 + 0.001 * np.sin(9 * TIMES)]
)
YAWS = (0.8 * TIMES + np.pi) % (2 * np.pi) - np.pi
TURNS = Rotation.from_euler(
    "ZYX", np.column_stack([YAWS, 0.004 * np.sin(5 * TIMES), 0.003 * np.cos(3 * TIMES)])
)


def assert_poses(read: Trajectory, stamps: np.ndarray = TIMES, turns: Rotation = TURNS) -> None:
    np.testing.assert_allclose(read.stamps, stamps, atol=1e-6)
    np.testing.assert_allclose(read.positions, PLACES, atol=2e-6)
    apart = (turns.inv() * Rotation.from_quat(read.quaternions)).magnitude()
    assert apart.max() < 1e-4


# --- Qualisys ----------------------------------------------------------------------------------

NAMES = ("X", "Y", "Z", "Roll", "Pitch", "Yaw", "Residual", *(f"Rot[{k}]" for k in range(9)))


def tsv(*bodies: str, included: str = "6D", lost: slice | None = None, empty: str = "0.000") -> str:
    lines = [
        f"NO_OF_FRAMES\t{len(TIMES)}",
        "NO_OF_CAMERAS\t4",
        f"NO_OF_BODIES\t{len(bodies)}",
        "FREQUENCY\t100",
        "NO_OF_ANALOG\t0",
        "ANALOG_FREQUENCY\t0",
        "DESCRIPTION\t--",
        "TIME_STAMP\t2024-01-22, 17:47:17\t22107.99179716",
        f"DATA_INCLUDED\t{included}",
        "EVENT\tstart\t12\t0.11",
        "BODY_NAMES\t" + "\t".join(bodies),
        "\t".join(["Frame", "Time", *(f"{body} X\t" + "\t".join(NAMES[1:]) for body in bodies)])
        + "\t",
    ]
    gone = range(len(TIMES))[lost] if lost else range(0)
    for row, matrix in enumerate(TURNS.as_matrix()):
        cells = [f"{row + 1}", f"{TIMES[row]:.5f}"]
        for number in range(len(bodies)):
            place = 1000 * PLACES[row] + 500 * number
            # Some other angles, as the program can be told: only the matrix counts.
            values = [*place, 11.0, 22.0, 33.0, 0.4, *matrix.T.ravel()]
            cells += [empty] * 16 if row in gone else [f"{value:.5f}" for value in values]
        lines.append("\t".join(cells) + "\t")
    return "\r\n".join(lines) + "\r\n"


def test_the_tsv_of_qualisys_is_read(tmp_path: Path) -> None:
    path = tmp_path / "drive_6D.tsv"
    path.write_text(tsv("Robot"), encoding="utf-8")
    read = read_trajectory(path)
    assert_poses(read)
    assert "FREQUENCY: 100" in read.notes


@pytest.mark.parametrize("empty", ["", "0.000", "NaN"])
def test_where_qualisys_lost_the_body_there_is_no_pose(empty: str) -> None:
    read = parse_trajectory(tsv("Robot", lost=slice(100, 300), empty=empty), "a.tsv")
    assert len(read) == len(TIMES) - 200
    np.testing.assert_allclose(np.diff(read.stamps).max(), 2.01, atol=1e-6)


def test_of_several_bodies_of_qualisys_one_is_chosen() -> None:
    text = tsv("Robot", "Big Box")
    assert_poses(parse_trajectory(text, "a.tsv", "Robot"))
    box = parse_trajectory(text, "a.tsv", "Big Box")
    np.testing.assert_allclose(box.positions, PLACES + 0.5, atol=2e-6)
    with pytest.raises(TrajectoryError, match=r"line 12: several .* 'Robot', 'Big Box'"):
        parse_trajectory(text, "a.tsv")
    with pytest.raises(TrajectoryError, match="no rigid body 'robot'; valid are 'Robot'"):
        parse_trajectory(text, "a.tsv", "robot")


MARKERS = (
    "NO_OF_FRAMES\t2\nFREQUENCY\t100\nDATA_INCLUDED\t3D\nMARKER_NAMES\ta\tb\n"
    "1.0\t2.0\t3.0\t4.0\t5.0\t6.0\n1.0\t2.0\t3.0\t4.0\t5.0\t6.0\n"
)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (MARKERS, "Qualisys's TSV of 3D, without rigid bodies; valid is that of 6D data"),
        (tsv("Robot").replace("Frame\tTime\t", "Frame\tNumber\t"), "no column Time"),
        (tsv("Robot", lost=slice(None)), "the rigid body is in no row"),
        (tsv("Robot").replace("\t0.01000\t", "\tsoon\t"), "line 14"),
        (
            tsv("Robot").replace("Residual\tRot[0]", "Rot[0]").replace("Robot X\tY", "Robot"),
            "no ri",
        ),
    ],
)
def test_a_tsv_that_is_none_of_ours_is_named(text: str, message: str) -> None:
    with pytest.raises(TrajectoryError, match=rf"a\.tsv.*{message}"):
        parse_trajectory(text, "a.tsv")


def test_a_matrix_that_is_no_rotation_is_named() -> None:
    rows = tsv("Robot").split("\r\n")
    rows[20] = "\t".join([*rows[20].split("\t")[:9], *["2.0"] * 9])
    with pytest.raises(TrajectoryError, match=r"a\.tsv, line 21: no rotation"):
        parse_trajectory("\n".join(rows), "a.tsv")


# --- Vicon -------------------------------------------------------------------------------------


def vicon(
    *bodies: str,
    title: str = "Objects",
    turns: str = "quaternions",
    unit: str = "rad",
    lost: slice | None = None,
) -> str:
    axes = "RX,RY,RZ,RW" if turns == "quaternions" else "RX,RY,RZ"
    count = axes.count(",") + 1
    units = ",".join([unit] * 3 + ([""] if count == 4 else []))
    values = {
        "quaternions": TURNS.as_quat(),
        "helical": TURNS.as_rotvec(),
        "euler": TURNS.as_euler("XYZ"),
        "tilted": TURNS.as_rotvec() + np.array([0.9, 0, 0]),
    }[turns]
    lines = [
        title,
        "100",
        ",," + ",".join(body + "," * (count + 2) for body in bodies),
        "Frame,Sub Frame," + ",".join([f"{axes},TX,TY,TZ"] * len(bodies)),
        ",," + ",".join([f"{units},mm,mm,mm"] * len(bodies)),
    ]
    gone = range(len(TIMES))[lost] if lost else range(0)
    per = np.degrees(1) if unit == "deg" else 1.0
    for row in range(len(TIMES)):
        cells = [f"{row}", "0"]
        for number in range(len(bodies)):
            shown = [*(per * values[row]), *(1000 * PLACES[row] + 500 * number)]
            cells += [""] * len(shown) if row in gone else [f"{value:.7g}" for value in shown]
        lines.append(",".join(cells))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("title", ["Objects", "Segments"])
def test_the_csv_of_vicon_is_read(title: str, tmp_path: Path) -> None:
    path = tmp_path / "drive.csv"
    text = vicon("Global Angle robot:robot", title=title)
    markers = "\nTrajectories\n100\n,,robot:a,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n"
    path.write_text(text + markers, encoding="utf-8")
    assert_poses(read_trajectory(path))
    path.write_text(text.replace("\n", "\r\n"), encoding="utf-8-sig")
    assert_poses(read_trajectory(path, "robot"))


@pytest.mark.parametrize("unit", ["rad", "deg"])
@pytest.mark.parametrize("turns", ["helical", "euler"])
def test_angles_of_vicon_give_the_heading_whatever_they_mean(turns: str, unit: str) -> None:
    read = parse_trajectory(vicon("Subject:Root", turns=turns, unit=unit), "a.csv")
    np.testing.assert_allclose(read.positions, PLACES, atol=2e-6)
    apart = (read.poses[:, 2] - YAWS + np.pi) % (2 * np.pi) - np.pi
    assert np.abs(apart).max() < 0.01
    assert any(note.startswith(UNDERSTOOD) and "no tilt" in note for note in read.notes)


def test_angles_of_a_tilted_body_need_quaternions() -> None:
    with pytest.raises(TrajectoryError, match=r"a\.csv, line \d+: .*an export of quaternions"):
        parse_trajectory(vicon("Subject:Root", turns="tilted"), "a.csv")


def test_of_several_bodies_of_vicon_one_is_chosen() -> None:
    text = vicon("Global Angle robot:robot", "Global Angle box:lid", lost=slice(10, 20))
    read = parse_trajectory(text, "a.csv", "box:lid")
    assert len(read) == len(TIMES) - 10
    np.testing.assert_allclose(read.positions[:10], PLACES[:10] + 0.5, atol=2e-6)
    with pytest.raises(TrajectoryError, match=r"line 3: several rigid .* 'robot', 'box:lid'"):
        parse_trajectory(text, "a.csv")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "Trajectories\n100\n,,robot:a,,\nFrame,Sub Frame,X,Y,Z\n,,mm,mm,mm\n1,0,1,2,3\n",
            "Vicon's CSV of Trajectories, without rigid bodies; valid is an export of objects",
        ),
        (vicon("a:b").replace("mm,mm,mm", "mm,mm,miles"), "unit is 'miles'; valid are m, cm, mm"),
        (vicon("a:b", turns="helical").replace(",,rad", ",,turns"), "unit is 'turns'"),
        (vicon("a:b").replace("TX,TY,TZ", "TX,TY,T"), "the body lacks TZ"),
        (vicon("").replace(",,,,,,,\n", "\n"), "no body has a name|not Vicon's header"),
        (vicon("a:b").replace("\n100\n", "\nfast\n"), "line 2: 'fast' is no number"),
        (vicon("a:b").replace("\n100\n", "\n0\n"), "the rate is 0"),
        (vicon("a:b", lost=slice(None)), "the rigid body is in no row"),
    ],
)
def test_a_csv_of_vicon_that_is_none_of_ours_is_named(text: str, message: str) -> None:
    with pytest.raises(TrajectoryError, match=rf"a\.csv.*({message})"):
        parse_trajectory(text, "a.csv")


# --- g2o ---------------------------------------------------------------------------------------


def graph(word: str = "VERTEX_SE2") -> str:
    lines = ["# a graph", "PARAMS_SE2OFFSET 0 0 0 0"]
    for number in reversed(range(len(TIMES))):
        x, y, z = PLACES[number]
        turn = [YAWS[number]] if word != "VERTEX_SE3:QUAT" else TURNS[number].as_quat()
        place = [x, y] if word != "VERTEX_SE3:QUAT" else [x, y, z]
        lines.append(f"{word} {number + 7} " + " ".join(f"{v:.9g}" for v in [*place, *turn]))
    lines += ["VERTEX_XY 9000 1.0 2.0", "FIX 7", "EDGE_SE2 7 8 1 0 0 500 0 0 500 0 500"]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("word", ["VERTEX_SE2", "VERTEX2"])
def test_the_poses_of_a_graph_are_read_in_the_order_of_their_numbers(word: str) -> None:
    read = parse_trajectory(graph(word), "a.g2o")
    np.testing.assert_allclose(read.stamps, 0.1 * np.arange(len(TIMES)), atol=1e-9)
    np.testing.assert_allclose(read.poses[:, :2], PLACES[:, :2], atol=1e-6)
    np.testing.assert_allclose(np.cos(read.poses[:, 2] - YAWS), 1, atol=1e-9)
    assert any("a.g2o has no stamps (times.txt beside it would)" in note for note in read.notes)


def test_stamps_beside_a_graph_count(tmp_path: Path) -> None:
    path = tmp_path / "map.g2o"
    path.write_text(graph("VERTEX_SE3:QUAT"), encoding="utf-8")
    (tmp_path / "times.txt").write_text("\n".join(f"{time:.6f}" for time in TIMES))
    assert_poses(read_trajectory(path))
    (tmp_path / "times.txt").write_text("0\n1\n")
    with pytest.raises(TrajectoryError, match=r"has 800 poses, and times\.txt 2"):
        read_trajectory(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n",
            "a graph without poses; valid are lines of VERTEX",
        ),
        ("VERTEX_SE2 0 1 2\n", "line 1: valid are VERTEX_SE2 number x y theta"),
        ("VERTEX_SE2 a 1 2 3\n", "line 1: valid are"),
        (f"VERTEX_SE2 {'9' * 5000} 1 2 3\n", "line 1: valid are"),
        ("VERTEX_SE2 0 1 2 x\n", "line 1: 'x' is no number"),
        ("VERTEX_SE2 0 1 2 inf\nVERTEX_SE2 1 1 2 3\n", "line 1: a number is not finite"),
        ("VERTEX_SE2 0 1 2 3\nVERTEX_SE2 0 1 2 3\n", "line 2: vertex 0 is in line 1, too"),
    ],
)
def test_a_graph_that_is_no_trajectory_is_named(text: str, message: str) -> None:
    with pytest.raises(TrajectoryError, match=rf"a\.g2o.*{message}"):
        parse_trajectory(text, "a.g2o")


def test_only_captures_have_bodies() -> None:
    with pytest.raises(TrajectoryError, match="Motive, Vicon and Qualisys have a rigid body"):
        parse_trajectory(graph(), "a.g2o", "robot")
