"""Exports as Motive writes them; the forms of the header are those of real files."""

import csv
import io
import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.features.lab.trajectories.motive import parse_motive
from app.features.lab.trajectories.reading import read_trajectory
from app.trajectories.trajectory import TrajectoryError

Z_UP_FROM_Y_UP = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
PER_METRE = {"Meters": 1, "Millimeters": 1e3, "Centimeters": 1e2, "Inches": 1 / 0.0254}


def eight(n=200):
    """Stamps and poses (n, 3) of a robot that weaves, and starts off the origin."""
    t = np.arange(n) / 100
    return t, np.column_stack([0.4 + 0.3 * np.sin(t), 0.2 * np.sin(2 * t) - 0.5, 0.9 * t - 1])


def in_motive(poses, height=0.08, up="y"):
    """Positions and rotations in Motive's axes of a body on the floor."""
    positions = np.column_stack([poses[:, :2], np.full(len(poses), height)])
    positions[:, 2] += 1e-4 * np.sin(np.arange(len(poses)))
    rotations = Rotation.from_euler("z", poses[:, 2:])
    if up == "z":
        return positions, rotations
    back = Rotation.from_matrix(Z_UP_FROM_Y_UP.T)
    return back.apply(positions), back * rotations * back.inv()


def export(
    bodies,
    stamps,
    units="Meters",
    rotation="Quaternion",
    version="1.23",
    markers=True,
    timecode=False,
    lost=(),
    take="drive 1, slow",
):
    """The text of a file with bodies {name: (positions, rotations)}."""
    columns = []  # type, name, id, parent, property, axis, values
    for number, (name, (positions, rotations)) in enumerate(bodies.items()):
        identity = f"{number}E207518D8A311E9"
        if rotation == "Quaternion":
            turns, axes = rotations.as_quat(), "XYZW"
        else:
            turns, axes = rotations.as_euler(rotation, degrees=True), rotation
        about = [(axis, turns[:, axes.index(axis)]) for axis in sorted(axes, key="XYZW".index)]
        body = ("Rigid Body", name, identity, "Root")
        columns += [(*body, "Rotation", axis, values) for axis, values in about]
        where = positions * PER_METRE[units]
        columns += [(*body, "Position", axis, where[:, k]) for k, axis in enumerate("XYZ")]
        columns.append((*body, "Mean Marker Error", "", np.full(len(stamps), 0.000113)))
        if markers:
            marker = ("Rigid Body Marker", f"{name}:Marker1", identity, name)
            columns += [
                (*marker, "Position", axis, where[:, k] + 1) for k, axis in enumerate("XYZ")
            ]
            columns.append((*marker, "Marker Quality", "", np.ones(len(stamps))))
    if markers:
        free = ("Marker", "Unlabeled 1189", "4CF0B31A", "")
        columns += [(*free, "Position", axis, np.full(len(stamps), 9.0)) for axis in "XYZ"]
        bone = ("Bone", "Skeleton:Hip", "900", "Root")
        columns += [(*bone, "Rotation", axis, np.full(len(stamps), 9.0)) for axis in "XYZW"]
    return written(
        columns, stamps, units=units, rotation=rotation, version=version, timecode=timecode,
        lost=lost, take=take,
    )  # fmt: skip


def written(columns, stamps, *, units, rotation, version, timecode, lost, take):
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\r\n")
    writer.writerow(
        [
            "Format Version", version, "Take Name", take, "Take Notes", "",
            "Capture Frame Rate", "100.000000", "Export Frame Rate", "100.000000",
            "Capture Start Time", "2019-09-18 04.30.02.695 PM",
            "Total Exported Frames", len(stamps), "Rotation Type", rotation,
            "Length Units", units, "Coordinate Space", "Global",
        ]
    )  # fmt: skip
    out.write("\r\n")
    labels = ["Type", "Name", "ID", "Parent", ""]
    kept = [0, 1, 2, 3, 4] if version >= "1.24" else [0, 1, 2, 4]
    filler = [""] if timecode else []
    for one in kept:
        label = "" if version < "1.22" else labels[one]
        writer.writerow(["", label, *filler, *(column[one] for column in columns)])
    writer.writerow(
        ["Frame", "Time (Seconds)", *(["TimeCode"] if timecode else []), *(c[5] for c in columns)]
    )
    for index, stamp in enumerate(stamps):
        code = ["15:26:46:12.02"] if timecode else []
        cells = [
            "" if index in lost and column[0] != "Marker" else f"{column[6][index]:.6f}"
            for column in columns
        ]
        writer.writerow([index, f"{stamp:.6f}", *code, *cells])
    return out.getvalue()


def assert_same(trajectory, stamps, poses, atol=2e-5):
    np.testing.assert_allclose(trajectory.stamps, stamps, atol=1e-9)
    off = trajectory.poses - poses
    off[:, 2] = np.angle(np.exp(1j * off[:, 2]))
    np.testing.assert_allclose(off, 0, atol=atol)


@pytest.mark.parametrize("units", PER_METRE)
@pytest.mark.parametrize("version", ["1.21", "1.23", "1.25"])
@pytest.mark.parametrize("up", ["y", "z"])
def test_a_robot_on_the_floor_is_where_it_was(units, version, up):
    stamps, poses = eight()
    text = export({"Robot": in_motive(poses, up=up)}, stamps, units, version=version)
    trajectory = parse_motive(text, "take.csv")
    assert_same(trajectory, stamps, poses)
    np.testing.assert_allclose(trajectory.positions[:, 2], 0.08, atol=2e-4)
    assert f"up: {up}" in trajectory.notes
    assert "Take Name: drive 1, slow" in trajectory.notes


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_euler_angles_of_any_order_are_turns_about_own_axes(order):
    stamps, poses = eight(60)
    positions, rotations = in_motive(poses)
    tilted = rotations * Rotation.from_euler("xyz", [0.1, 0.2, -0.15])
    of_angles = parse_motive(
        export({"Robot": (positions, tilted)}, stamps, rotation=order.upper()), "take.csv"
    )
    of_quaternions = parse_motive(export({"Robot": (positions, tilted)}, stamps), "take.csv")
    agreement = np.abs((of_angles.quaternions * of_quaternions.quaternions).sum(axis=1))
    np.testing.assert_allclose(agreement, 1, atol=1e-9)


def test_two_turns_in_degrees_have_the_pose_that_they_say():
    """By hand: 90 deg about x, then 45 deg about the body's new y, which is the world's z."""
    body = Rotation.from_euler("XYZ", [90, 45, 0], degrees=True)
    np.testing.assert_allclose(body.apply([1, 0, 0]), np.sqrt([0.5, 0.5, 0]), atol=1e-12)
    stamps, poses = eight(200)
    positions, _ = in_motive(poses, up="z")
    text = export({"R": (positions, Rotation.concatenate([body] * 200))}, stamps, rotation="XYZ")
    assert parse_motive(text, "a.csv").poses[0, 2] == pytest.approx(math.pi / 4)


@pytest.mark.parametrize("seed", range(6))
def test_of_a_drive_straight_along_x_y_is_up(seed):
    """Noise alone says nothing of what is up."""
    rng = np.random.default_rng(seed)
    stamps = np.arange(100) / 50
    positions = np.column_stack([0.2 * stamps, *rng.normal(0, 2e-4, (2, 100))])
    level = Rotation.identity(100)
    read = parse_motive(export({"R": (positions, level)}, stamps), "a.csv")
    assert "up: y" in read.notes
    np.testing.assert_allclose(read.poses[:, 0], positions[:, 0], atol=1e-6)
    np.testing.assert_allclose(read.poses[:, 1], -positions[:, 2], atol=1e-6)


@pytest.mark.parametrize("bom", ["", "\ufeff"])
def test_a_file_with_and_without_byte_order_mark_is_read(tmp_path, bom):
    stamps, poses = eight(30)
    path = tmp_path / "take.csv"
    path.write_text(bom + export({"Robot": in_motive(poses)}, stamps, take="Übung"), "utf-8")
    assert_same(read_trajectory(path), stamps, poses)


def test_rows_where_the_body_was_lost_are_left_out():
    stamps, poses = eight(50)
    lost = set(range(10, 30))
    trajectory = parse_motive(export({"R": in_motive(poses)}, stamps, lost=lost), "take.csv")
    kept = [i for i in range(50) if i not in lost]
    assert_same(trajectory, stamps[kept], poses[kept])


def test_a_column_of_time_codes_moves_nothing():
    stamps, poses = eight(20)
    assert_same(
        parse_motive(export({"R": in_motive(poses)}, stamps, timecode=True), "a.csv"), stamps, poses
    )


def test_of_several_bodies_one_must_be_named():
    stamps, poses = eight(20)
    there = poses + np.array([1, 2, 0.5])
    bodies = {"Robot": in_motive(poses), "Box": in_motive(there)}
    text = export(bodies, stamps)
    assert_same(parse_motive(text, "take.csv", "Box"), stamps, there)
    with pytest.raises(TrajectoryError, match=r"take.csv, line 4: several .* 'Robot', 'Box'"):
        parse_motive(text, "take.csv")
    with pytest.raises(TrajectoryError, match=r"no rigid body 'robot'; valid are 'Robot', 'Box'"):
        parse_motive(text, "take.csv", "robot")


def edited(*pairs):
    stamps, poses = eight(20)
    text = export({"R": in_motive(poses)}, stamps)
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (edited(("Meters", "Cubits")), "line 1: Length Units is 'Cubits'; valid are Meters, Cent"),
        (edited(("Quaternion", "Angles")), "line 1: Rotation Type is 'Angles'; valid are Quat"),
        (edited(("Frame,Time", "Bild,Zeit")), "not Motive's header; valid are rows of Type"),
        (edited(("Rigid Body", "Soft Body")), "line 3: no column is of a Rigid Body"),
        (edited((",Rotation,", ",Turn,")), "line 6: 'R' lacks Rotation X"),
        (edited(("0.130000", "0.1e")), "line 21: '0.1e' is no number"),
        (edited(("0.130000", "0.110000")), "line 21: stamp 0.11 follows 0.12"),
        (edited(("0.130000", "0.120000")), "line 21: stamp 0.12 is repeated"),
        (edited(("0.130000", "nan")), "line 21: a number is not finite"),
        (edited(("\n13,0.130000,0.000000,", "\n13,0.130000,,")), "line 21: cells of the pose are"),
        (edited(("\n13,0.130000,", "\n13,,")), "line 21: cells of the pose are empty"),
        (edited().split("\r\n0,")[0], "the rigid body is in no row"),
        (edited().split("\r\n1,")[0], "has 1 pose"),
        ("Format Version,1.23", "Length Units is ''|not Motive's header"),
        ('Format Version,"1.23\n\n' + "x" * 200_000, "field larger than"),
    ],
)
def test_bad_files_are_refused_with_file_and_line(text, message):
    with pytest.raises(TrajectoryError, match=message) as caught:
        parse_motive(text, "take.csv")
    assert "take.csv" in str(caught.value)


def test_a_file_without_the_body_anywhere_says_so():
    stamps, poses = eight(20)
    text = export({"R": in_motive(poses)}, stamps, lost=range(20))
    with pytest.raises(TrajectoryError, match="the rigid body is in no row"):
        parse_motive(text, "take.csv")
