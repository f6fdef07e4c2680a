"""The robot's description is read whole, or refused with a reason."""

from __future__ import annotations

import math
import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from shapely import MultiPoint, Polygon

from robot.description.rigid_bodies import with_inertia
from robot.description.robot_model import read_model
from robot.description.spec import SPIKE, RobotSpec, SpecError
from robot.description.urdf import origin_of, shape_of

SPEC = RobotSpec.load()
TEXT = SPIKE.read_text()
LENS = SPIKE.parent / "pi_camera.yaml"
JOINT_A = '<joint name="left_wheel_joint">\n      <param name="port">A</param>'


def test_the_wheels_are_those_of_a_spike_robot() -> None:
    assert SPEC.wheel_radius == pytest.approx(0.028)
    assert SPEC.track == pytest.approx(0.112)
    left, right = (SPEC.joints[place] for place in SPEC.axle)
    assert (left.name, right.name) == ("left_wheel_joint", "right_wheel_joint")
    assert [left.offset, right.offset] == pytest.approx([0.056, -0.056])
    assert {left.port, right.port} == {"A", "B"}
    assert left.direction == -right.direction, "the motors are mounted as mirror images"


def test_the_speed_is_that_of_the_slower_wheel() -> None:
    assert SPEC.max_v == pytest.approx(0.028 * 14.14)
    assert SPEC.max_omega == pytest.approx(2 * SPEC.max_v / SPEC.track)
    assert SPEC.with_wheels([0.028, 0.020], 0.1).max_v == pytest.approx(0.020 * 14.14)


def test_the_camera_is_mounted_as_measured() -> None:
    at = SPEC.robot_from_camera
    np.testing.assert_allclose(at[:3, 3], [0.060, 0, 0.160], atol=1e-9)
    along = math.radians(35)
    np.testing.assert_allclose(at[:3, 2], [math.cos(along), 0, -math.sin(along)], atol=1e-9)
    np.testing.assert_allclose(at[:3, 0], [0, -1, 0], atol=1e-9, err_msg="x is to the right")


def test_the_lens_lies_beside_the_description() -> None:
    assert (SPEC.lens.width, SPEC.lens.height) == (640, 480)
    np.testing.assert_allclose(SPEC.lens.matrix.ravel(), [530, 0, 319.5, 0, 530, 239.5, 0, 0, 1])
    np.testing.assert_allclose(SPEC.lens.distortion, [0.16, -0.28, 0, 0, 0])


def test_the_camera_sees_the_floor_ahead_from_near_to_far() -> None:
    middle = SPEC.lens.matrix[0, 2]
    near, far = SPEC.floor_view.floor_points(np.array([[middle, 479.0], [middle, 0.0]]))
    assert 0.14 < near[0] < 0.17 and 0.7 < far[0] < 1.1
    assert abs(near[1]) < 1e-9 and abs(far[1]) < 1e-9


def parts() -> list[tuple[str, np.ndarray]]:
    """Points in the robot frame on each visible part, by the name of its link."""
    root, model = ElementTree.fromstring(SPEC.urdf), read_model(SPEC.urdf)
    found = []
    for link in root.findall("link"):
        name = str(link.get("name"))
        robot_from_link = model.transform(name, "base_footprint")
        for visual in link.findall("visual"):
            at = robot_from_link @ origin_of(visual, name)
            points = shape_of(visual, name).corners()
            found.append((name, points @ at[:3, :3].T + at[:3, 3]))
    return found


def test_the_camera_does_not_see_the_robot() -> None:
    camera_from_robot = np.linalg.inv(SPEC.robot_from_camera)
    for name, points in parts():
        seen = points @ camera_from_robot[:3, :3].T + camera_from_robot[:3, 3]
        pixels = SPEC.lens.project(seen)
        assert not SPEC.floor_view.inside(pixels).any(), f"{name} is in the picture"


def test_every_part_is_above_the_floor_and_inside_the_outline() -> None:
    outline = Polygon(SPEC.outline).buffer(1e-6)
    for name, points in parts():
        assert points[:, 2].min() > -1e-9, f"{name} is in the floor"
        assert outline.contains(MultiPoint(points[:, :2])), f"{name} sticks out"


def test_the_outline_is_convex_and_anticlockwise() -> None:
    ring = Polygon(SPEC.outline).exterior
    assert ring.is_ccw
    assert Polygon(ring).convex_hull.area == pytest.approx(Polygon(ring).area)


def test_other_wheels_can_be_read_back_from_the_changed_description() -> None:
    changed = SPEC.with_wheels([0.0275, 0.0285], 0.115)
    again = RobotSpec.from_urdf(changed.urdf, SPIKE.parent)
    for ours, theirs in zip(changed.joints, again.joints, strict=True):
        assert (ours.name, ours.port, ours.direction) == (
            theirs.name,
            theirs.port,
            theirs.direction,
        )
        assert ours.radius == pytest.approx(theirs.radius)
        assert ours.offset == pytest.approx(theirs.offset)
    assert [joint.radius for joint in changed.joints] == [0.0275, 0.0285]
    assert changed.track == pytest.approx(0.115)
    assert changed.wheel_radius == pytest.approx(0.028)
    np.testing.assert_array_equal(changed.robot_from_camera, SPEC.robot_from_camera)
    assert SPEC.track == pytest.approx(0.112), "the first one is as it was"


def test_bigger_wheels_get_their_own_inertia() -> None:
    changed = SPEC.with_wheels([0.030, 0.030], 0.112)
    assert changed.urdf == with_inertia(changed.urdf)
    assert changed.urdf != SPEC.urdf


@pytest.mark.parametrize(
    ("radii", "track"),
    [([0.028], 0.1), ([0.028, 0], 0.1), ([0.028, -1], 0.1), ([math.nan, 0.028], 0.1)]
    + [([0.028, 0.028], track) for track in (0.0, -0.1, math.inf, math.nan)],
)
def test_impossible_wheels_are_refused(radii: list[float], track: float) -> None:
    with pytest.raises(SpecError):
        SPEC.with_wheels(radii, track)


def replaced(old: str, new: str, count: int = -1) -> str:
    assert old in TEXT
    return TEXT.replace(old, new, count)


def without(start: str, end: str) -> str:
    """The description without what lies between two marks, the first of its kind."""
    first = TEXT.index(start)
    return TEXT[:first] + TEXT[TEXT.index(end, first) + len(end) :]


LAUGHS = '<!DOCTYPE robot [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;">]>'
LEFT_WHEEL_VISUAL = '<cylinder radius="0.028" length="0.014"/>'

BROKEN = {
    "empty": ("", "no readable XML"),
    "no XML": ("a robot", "no readable XML"),
    "cut off": (TEXT[: len(TEXT) // 2], "no readable XML"),
    "another root": ("<sdf/>", "expected <robot>"),
    "an entity bomb": (LAUGHS + "<robot>&b;</robot>", "document type"),
    "no links": ("<robot/>", "0 links hang on no other"),
    "no wheels": (without("<ros2_control", "</ros2_control>"), "0 joints .* two"),
    "one wheel": (without('    <joint name="right_wheel_joint">', "</joint>"), "1 joints .* two"),
    "a wheel twice": (
        replaced('<joint name="right_wheel_joint">', '<joint name="left_wheel_joint">'),
        "listed twice",
    ),
    "a wheel that is no joint": (
        replaced('<joint name="right_wheel_joint">', '<joint name="middle_joint">'),
        "'middle_joint'; there are: left_wheel_joint, right_wheel_joint",
    ),
    "a wheel that is fixed": (
        replaced('"left_wheel_joint" type="continuous"', '"left_wheel_joint" type="fixed"'),
        "no continuous joint is called 'left_wheel_joint'",
    ),
    "no radius": (replaced(LEFT_WHEEL_VISUAL, '<cylinder length="0.014"/>'), "lacks radius"),
    "no shape": (replaced(LEFT_WHEEL_VISUAL, ""), "valid are box, cylinder, sphere"),
    "a radius of zero": (replaced(LEFT_WHEEL_VISUAL, LEFT_WHEEL_VISUAL.replace("0.028", "0")), "0"),
    "a radius below zero": (replaced('radius="0.028"', 'radius="-0.028"'), "above zero"),
    "a radius of nan": (replaced('radius="0.028"', 'radius="nan"'), "finite"),
    "a square wheel": (
        replaced(LEFT_WHEEL_VISUAL, '<box size="0.05 0.01 0.05"/>'),
        "valid are cylinder and sphere",
    ),
    "a wheel on its side": (
        replaced(f'<visual><origin rpy="1.570796326794897 0 0"/><geometry>{LEFT_WHEEL_VISUAL}',
                 f"<visual><geometry>{LEFT_WHEEL_VISUAL}"),
        "along y",
    ),
    "a tyre of another size": (replaced('<sphere radius="0.028"/>', '<sphere radius="0.03"/>'),
                               "collision"),
    "a wheel above the floor": (replaced('xyz="0 0 0.028"', 'xyz="0 0 0.03"'), "above the floor"),
    "an axle elsewhere": (replaced('xyz="0 0 0.028"', 'xyz="0.01 0 0.028"'), "under the axle"),
    "an axle off the middle": (replaced('xyz="0 0.056 0"', 'xyz="0 0.07 0"'), "in the middle"),
    "no track": (
        replaced('xyz="0 0.056 0"', 'xyz="0 0 0"').replace('xyz="0 -0.056 0"', 'xyz="0 0 0"'),
        "in the middle",
    ),
    "a place of nan": (replaced('xyz="0 0.056 0"', 'xyz="0 nan 0"'), "finite|no usable"),
    "an axle that drives backward": (replaced('axis xyz="0 1 0"', 'axis xyz="0 -1 0"'), "'0 1 0'"),
    "an axis of zero": (replaced('axis xyz="0 1 0"', 'axis xyz="0 0 0"'), "point somewhere"),
    "no axis": (replaced('<axis xyz="0 1 0"/>', ""), "<axis> is missing"),
    "no limit": (replaced('<limit effort="0.035" velocity="14.14"/>', ""), "<limit> is missing"),
    "no speed limit": (replaced(' velocity="14.14"', ""), "lacks velocity"),
    "a torque of zero": (replaced('effort="0.035"', 'effort="0"'), "above zero"),
    "another speed limit": (replaced('"max">14.14', '"max">20'), "14.14"),
    "a speed limit in words": (replaced('"max">14.14', '"max">fast'), "14.14"),
    "port E": (replaced(JOINT_A, JOINT_A.replace(">A<", ">E<")), "valid are A, B, C, D"),
    "no port": (replaced('<param name="port">A</param>', ""), "port.* is missing"),
    "an empty port": (replaced(">A<", "> <"), "port.* is missing"),
    "one port for both": (replaced(">A<", ">B<"), "each needs its own"),
    "a direction of 2": (replaced('"direction">1<', '"direction">2<'), "valid are 1 and -1"),
    "no direction": (replaced('<param name="direction">1</param>', ""), "direction.* is missing"),
    "no camera": (without("<sensor", "</sensor>"), "no camera"),
    "a lens elsewhere": (replaced(">pi_camera.yaml<", ">../pi_camera.yaml<"), "beside the desc"),
    "no camera frame": (replaced(">camera_optical_frame<", ">camera<"), "'camera' is no link"),
    "a camera that looks up": (
        replaced('0.132" rpy="0 0.6108652381980153 0"', '0.132" rpy="0 -0.6 0"'), "looks up"
    ),
    "a camera in the floor": (replaced('xyz="0.060 0 0.132"', 'xyz="0.060 0 -0.1"'), "high"),
    "no lens": (replaced("pi_camera.yaml", "absent.yaml"), "absent.yaml"),
    "another root link": (replaced("base_footprint", "floor"), "base_footprint"),
    "a joint to nowhere": (
        replaced('<parent link="camera_link"/>', '<parent link="x"/>'), "no link 'x'"
    ),
    "a ring of links": (
        replaced('child link="base_link"', 'child link="base_footprint"'), "in a ring"
    ),
    "a link on two joints": (
        replaced('child link="right_wheel"', 'child link="left_wheel"'), "another joint already"
    ),
    "a name twice": (TEXT.replace("<joint", '<link name="hub"/><joint', 1), "name of its own"),
}  # fmt: skip


@pytest.mark.parametrize(("text", "said"), BROKEN.values(), ids=BROKEN.keys())
def test_a_broken_description_is_refused_by_name(text: str, said: str, tmp_path: Path) -> None:
    shutil.copy(LENS, tmp_path)
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(SpecError, match=said) as refused:
        RobotSpec.load(path)
    assert str(path) in str(refused.value)


def test_a_missing_file_is_refused_by_name(tmp_path: Path) -> None:
    with pytest.raises(SpecError, match=r"absent\.urdf"):
        RobotSpec.load(tmp_path / "absent.urdf")


def test_a_file_of_bytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    path.write_bytes(bytes(range(256)))
    with pytest.raises(SpecError, match="no readable"):
        RobotSpec.load(path)
