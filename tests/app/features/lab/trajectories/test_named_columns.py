"""Tables are read by the names in their header, whatever the order."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.features.lab.trajectories.reading import parse_trajectory, read_trajectory
from app.trajectories.trajectory import TrajectoryError

COUNT = 20
EUROC = (
    "#timestamp{unit}, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
    "q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], "
    "b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], "
    "b_a_RS_S_z [m s^-2]"
)


@pytest.fixture(scope="module")
def path():
    """Stamps (n,) [s], positions (n, 3) [m], quaternions (n, 4) x y z w."""
    rng = np.random.default_rng(3)
    turns = Rotation.from_rotvec(rng.normal(size=(COUNT, 3))).as_quat(canonical=True)
    return 100 + np.arange(COUNT) * 0.05, rng.normal(size=(COUNT, 3)), turns


def table(header, columns, separator=","):
    rows = [separator.join(f"{value:.12g}" for value in row) for row in np.column_stack(columns)]
    return "\n".join([header, *rows]) + "\n"


def assert_is(found, path, shift=0.0):
    stamps, positions, quaternions = path
    np.testing.assert_allclose(found.stamps, stamps + shift, atol=1e-6)
    np.testing.assert_allclose(found.positions, positions, atol=1e-9)
    np.testing.assert_allclose(found.quaternions, quaternions, atol=1e-9)


@pytest.mark.parametrize(
    ("header", "order"),
    [
        ("stamp,x,y,z,q_w,q_x,q_y,q_z", "wxyz"),
        ("stamp,x,y,z,qx,qy,qz,qw", "xyzw"),
        ("# timestamp,tx,ty,tz,qw,qx,qy,qz", "wxyz"),
        ("t, p_x, p_y, p_z, q_z, q_y, q_x, q_w", "zyxw"),
        ("Time [s],Pos_X [m],Pos_Y [m],Pos_Z [m],Quat_W,Quat_X,Quat_Y,Quat_Z", "wxyz"),
        ("time_s,x_m,y_m,z_m,qw,qx,qy,qz", "wxyz"),
        ("stamp,pose.position.x,pose.position.y,pose.position.z,pose.orientation.x,"
         "pose.orientation.y,pose.orientation.z,pose.orientation.w", "xyzw"),
    ],
)  # fmt: skip
def test_quaternions_are_read_by_name(path, header, order):
    stamps, positions, quaternions = path
    turned = quaternions[:, ["xyzw".index(one) for one in order]]
    assert_is(parse_trajectory(table(header, [stamps, positions, turned]), "a.csv"), path)


@pytest.mark.parametrize("comment", ["# ", ""])
@pytest.mark.parametrize("separator", [" ", "\t"])
def test_names_may_stand_apart_by_spaces(path, comment, separator):
    stamps, positions, quaternions = path
    header = f"# of a drive\n{comment}timestamp [s] x y z qw qx qy qz"
    rows = [stamps, positions, quaternions[:, [3, 0, 1, 2]]]
    assert_is(parse_trajectory(table(header, rows, separator), "a.txt"), path)


@pytest.mark.parametrize(("unit", "many"), [("ns", 1e9), ("us", 1e6), ("ms", 1e3), ("s", 1)])
def test_units_are_read(path, unit, many):
    stamps, positions, quaternions = path
    header = f"stamp [{unit}],x [mm],y [cm],z,qx,qy,qz,qw"
    scaled = positions * [1e3, 1e2, 1]
    assert_is(parse_trajectory(table(header, [stamps * many, scaled, quaternions]), "a"), path)


def test_columns_in_any_order_among_others_with_words(path):
    stamps, positions, quaternions = path
    header = "state,y,x,z,qw,qz,qy,qx,stamp"
    rows = [
        f"certain,{y:.12f},{x:.12f},{z:.12f},{qw:.12f},{qz:.12f},{qy:.12f},{qx:.12f},{stamp:.6f}"
        for stamp, (x, y, z), (qx, qy, qz, qw) in zip(stamps, positions, quaternions, strict=True)
    ]
    assert_is(parse_trajectory("\n".join([header, *rows]), "a.csv"), path)


@pytest.mark.parametrize("unit", [" [ns]", ""])
def test_evo_reads_the_same_of_euroc(path, tmp_path, monkeypatch, unit):
    monkeypatch.setenv("HOME", str(tmp_path))
    from evo.tools.file_interface import read_euroc_csv_trajectory

    _, positions, (turns) = path
    stamps = 1403636580838555648 + 5_000_000 * np.arange(COUNT)
    rows = [
        ",".join([str(stamp), *(f"{one:.6f}" for one in (*p, q[3], *q[:3])), *["0.1"] * 9])
        for stamp, p, q in zip(stamps, positions, turns, strict=True)
    ]
    file = tmp_path / "data.csv"
    file.write_text("\r\n".join([EUROC.format(unit=unit), *rows]) + "\r\n")
    found, theirs = read_trajectory(file), read_euroc_csv_trajectory(file)
    np.testing.assert_array_equal(found.stamps, theirs.timestamps)
    np.testing.assert_array_equal(found.positions, theirs.positions_xyz)
    wxyz = theirs.orientations_quat_wxyz
    np.testing.assert_allclose(found.quaternions, wxyz[:, [1, 2, 3, 0]], atol=1e-5)


PLANE = "stamp,x,y,theta [rad]"


@pytest.mark.parametrize(
    ("header", "many"),
    [
        ("time,x,y,yaw", (1, 1, 1)),
        ("t,x,y,theta", (1, 1, 1)),
        (PLANE, (1, 1, 1)),
        ("time [s],x [mm],y [mm],heading [deg]", (1, 1e3, 180 / np.pi)),
        ("stamp_ns,x_m,y_m,yaw_deg", (1e9, 1, 180 / np.pi)),
        ("__time,/odom/pose/pose/position/x,/odom/pose/pose/position/y,"
         "/odom/pose/pose/orientation/yaw", (1, 1, 1)),
    ],
)  # fmt: skip
def test_poses_on_a_floor_are_read_with_their_heading(header, many):
    stamps, yaw = 100 + np.arange(COUNT) * 0.1, np.linspace(-3, 9, COUNT)
    places = np.column_stack([np.cos(yaw), np.sin(yaw)])
    rows = [stamps * many[0], places * many[1], yaw * many[2]]
    found = parse_trajectory(table(header, rows), "a.csv")
    np.testing.assert_allclose(found.stamps, stamps, atol=1e-6)
    np.testing.assert_allclose(found.positions, np.column_stack([places, np.zeros(COUNT)]))
    turns = Rotation.from_quat(found.quaternions).as_rotvec()
    np.testing.assert_allclose(np.exp(1j * turns[:, 2]), np.exp(1j * yaw), atol=1e-9)
    assert found.planar


def test_a_table_of_a_message_has_its_own_stamp_beside_that_of_the_recorder(path):
    stamps, positions, quaternions = path
    header = (
        "%time,field.header.seq,field.header.stamp,field.pose.pose.position.x,"
        "field.pose.pose.position.y,field.pose.pose.position.z,field.pose.pose.orientation.x,"
        "field.pose.pose.orientation.y,field.pose.pose.orientation.z,field.pose.pose.orientation.w"
    )
    rows = [stamps + 7, np.arange(COUNT), stamps, positions, quaternions]
    assert_is(parse_trajectory(table(header, rows), "a.csv"), path)
    slashes = header.replace("field.", "/odom/").replace(".", "/").replace("%time", "__time")
    assert_is(parse_trajectory(table(slashes, rows), "a.csv"), path)


@pytest.mark.parametrize("wrapped", [True, False])
def test_degrees_without_their_unit_are_asked_about(wrapped):
    stamps, yaw = np.arange(200) * 0.1, np.arange(200) * (1.0 if wrapped else 3.0)
    rows = [stamps, np.zeros((200, 2)), (yaw + 90) % 360 - 180 if wrapped else yaw]
    with pytest.raises(TrajectoryError, match=r"line 1: is the yaw in degrees\? .*yaw \[deg\]"):
        parse_trajectory(table("t,x,y,yaw", rows), "a.csv")
    assert parse_trajectory(table("t,x,y,yaw [rad]", rows), "a.csv").planar


ROW = "1,0,0,0,0,0,0,1\n2,1,0,0,0,0,0,1\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("stamp,x,y,z,a,b,c,d\n" + ROW, "line 1: the header has none of qx, none of qy"),
        ("#a,b,c,d,e,f,g,h\n" + ROW, "line 1: the header has none of stamp, none of x"),
        ("stamp,x,y,z,qx,qy,qz,qx\n" + ROW, "2 columns of qx, none of qw"),
        ("stamp,x,y,z,qx,qy,qz\n" + ROW, "none of qw; valid are columns of stamp, x, y, z, qx"),
        ("stamp [h],x,y,z,qx,qy,qz,qw\n" + ROW, "unit 'h'; valid are s, sec, ms, us, ns"),
        ("stamp,x [ft],y,z,qx,qy,qz,qw\n" + ROW, "unit 'ft'; valid are m, cm, mm"),
        ("stamp,x,y,z,qx,qy,qz,qw\n1,2\n", "line 2: 2 cells; valid are 8"),
        ("stamp,x,y,z,qx,qy,qz,qw\n1,,0,0,0,0,0,1\n", "line 2: '' is no number"),
        ("stamp,x,y,z,qx,qy,qz,qw\n", "no poses"),
        ("stamp,x,yaw,qx,a,b,c,d\n" + ROW, "none of y; valid are .*or of stamp, x, y, yaw"),
        ("t,x,y,yaw [turns],a,b,c,d\n" + ROW, "unit 'turns'; valid are rad, deg"),
        ("name,of,nothing\n" + ROW, "'name' is no number; valid are TUM text .* header"),
    ],
)
def test_a_header_that_cannot_be_understood_is_refused_with_what_is_valid(text, message):
    with pytest.raises(TrajectoryError, match=message) as caught:
        parse_trajectory(text, "t.csv")
    assert "t.csv" in str(caught.value)


@pytest.mark.parametrize(
    "comment",
    ["# one robot, two laps", "# a file of poses that robot three drove", "# x y z", "#", "# x, y"],
)
def test_a_remark_is_no_header(comment):
    found = parse_trajectory(f"{comment}\n{ROW}".replace(",", " "), "t.txt")
    np.testing.assert_array_equal(found.positions[1], [1, 0, 0])
