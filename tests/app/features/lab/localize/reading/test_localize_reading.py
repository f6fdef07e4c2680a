"""What is read of a bag: scans, frames and odometry."""

import math
from types import SimpleNamespace as Object

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from paired_bags import paired

from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.laser_scan import ScanReader
from app.features.lab.localize.reading.layout import choose, find_layout
from app.features.lab.localize.reading.odometry import OdometryTrack
from app.features.lab.localize.reading.sources import BagError
from app.features.lab.localize.reading.transforms import Rigid3, TransformTree, frame_name
from benchmarks.lasers.laser_bags import LaserBag
from robot.geometry import Pose2

ANYTHING = st.floats(width=32, allow_nan=True, allow_infinity=True)
ANGLE = st.floats(-3.1, 3.1)


def message(ranges, first=-1.0, step=0.1, low=0.1, high=10.0, last=None):
    values = np.asarray(ranges, dtype=np.float32)
    end = first + step * (len(values) - 1) if last is None else last
    return Object(
        angle_min=first, angle_max=end, angle_increment=step, ranges=values, range_min=low,
        range_max=high,
    )  # fmt: skip


def quaternion(roll, pitch, yaw):
    def turn(angle, axis):
        q = np.zeros(4)
        q[axis], q[3] = math.sin(angle / 2), math.cos(angle / 2)
        return q

    def times(a, b):
        (ax, ay, az, aw), (bx, by, bz, bw) = a, b
        return np.array([
            aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
        ])  # fmt: skip

    x, y, z, w = times(turn(yaw, 2), times(turn(pitch, 1), turn(roll, 0)))
    return Object(x=x, y=y, z=z, w=w)


def mounted(x=0.0, y=0.0, z=0.0, roll=0.0, pitch=0.0, yaw=0.0):
    return Rigid3.of(Object(x=x, y=y, z=z), quaternion(roll, pitch, yaw))


def tf(parent, child, rigid=None, stamp=0.0, **place):
    rotation = quaternion(place.pop("roll", 0.0), place.pop("pitch", 0.0), place.pop("yaw", 0.0))
    translation = Object(**({"x": 0.0, "y": 0.0, "z": 0.0} | place))
    one = Object(
        header=Object(frame_id=parent), child_frame_id=child,
        transform=Object(translation=translation, rotation=rotation),
    )  # fmt: skip
    return Object(transforms=[one])


@given(st.lists(ANYTHING, min_size=1, max_size=40), ANYTHING, ANYTHING, ANGLE, st.floats(-0.3, 0.3))
def test_whatever_a_laser_reports_a_scan_has_ranges_or_no_return(ranges, low, high, first, step):
    scan = ScanReader(mounted()).scan(message(ranges, first, step, low, high, last=first + 1), 1.0)
    if scan is None:
        assert step == 0
        return
    assert len(scan.ranges) == len(scan.bearings) == len(ranges)
    hit = scan.ranges[np.isfinite(scan.ranges)]
    assert (hit > 0).all()
    assert not np.isnan(scan.ranges).any()
    if math.isfinite(high) and high > max(low if math.isfinite(low) else 0, 0):
        assert (hit < high).all()


def test_rep_117_no_return_too_near_and_invalid_are_all_no_return():
    ranges = [math.nan, math.inf, -math.inf, 0.0, 0.05, 0.1, 5.0, 10.0, 11.0, -1.0]
    scan = ScanReader(mounted()).scan(message(ranges), 1.0)
    returned = np.isfinite(scan.ranges)
    assert np.flatnonzero(returned).tolist() == [5, 6]


@given(ANGLE, ANGLE, st.floats(0.2, 9.0), st.booleans())
def test_a_return_is_where_the_mounting_has_it(bearing, yaw, length, rolled):
    """Also of a laser that hangs upside down."""
    place = mounted(0.3, -0.2, 0.5, math.pi if rolled else 0.0, 0.0, yaw)
    scan = ScanReader(place).scan(message([length, length], bearing, -0.01), 1.0)
    seen = place.rotation @ np.array([math.cos(bearing), math.sin(bearing), 0.0]) * length
    expected = (seen + place.translation)[:2]
    assert scan.points()[0] == pytest.approx(expected, abs=1e-5)


def test_a_laser_that_looks_up_sees_less_far_over_the_floor():
    scan = ScanReader(mounted(pitch=math.radians(20))).scan(message([2.0, 2.0], 0.0, 0.1), 1.0)
    assert scan.ranges[0] == pytest.approx(2 * math.cos(math.radians(20)))


def test_a_laser_that_looks_at_the_ceiling_is_refused():
    with pytest.raises(BagError, match=r"tilted by 80 degrees; valid is up to 30"):
        ScanReader(mounted(pitch=math.radians(80)))


def test_an_absent_increment_follows_from_the_angles():
    scan = ScanReader(mounted()).scan(message([1.0, 1.0, 1.0], -1.0, 0.0, last=1.0), 1.0)
    assert scan.bearings == pytest.approx([-1.0, 0.0, 1.0])
    assert ScanReader(mounted()).scan(message([1.0, 1.0], 0.0, 0.0, last=0.0), 1.0) is None


@pytest.mark.parametrize(
    ("first", "step"), [(1e30, 0.1), (-1e30, 0.1), (0.0, 1e30), (math.nan, 0.1), (0.0, math.inf)]
)
def test_angles_that_are_no_lasers_make_no_scan(first, step):
    assert ScanReader(mounted()).scan(message([1, 2, 3], first, step), 1.0) is None


def test_a_scan_may_have_other_rays_than_the_one_before():
    reader = ScanReader(mounted())
    assert len(reader.scan(message([1.0] * 5), 1.0).bearings) == 5
    assert reader.scan(message([1.0] * 7, first=0.5), 2.0).bearings[0] == pytest.approx(0.5)
    assert reader.scan(message([]), 3.0) is None


@given(ANGLE, st.floats(-1.5, 1.5), ANGLE)
def test_a_transform_times_its_inverse_is_none(roll, pitch, yaw):
    one = mounted(1.0, -2.0, 0.5, roll, pitch, yaw)
    none = one @ one.inverse()
    assert none.rotation == pytest.approx(np.eye(3), abs=1e-9)
    assert none.translation == pytest.approx(np.zeros(3), abs=1e-9)


def test_frames_are_found_up_and_down_the_tree_and_slashes_do_not_matter():
    frames = TransformTree()
    frames.add(tf("/base_footprint", "base_link", z=0.1))
    frames.add(tf("base_link", "/mast", x=0.2, yaw=math.pi / 2))
    frames.add(tf("mast", "laser", x=0.5))
    found = frames.between("base_footprint", "laser")
    assert found.translation == pytest.approx([0.2, 0.5, 0.1])
    assert found.planar().theta == pytest.approx(math.pi / 2)
    assert frames.between("mast", "base_link").translation == pytest.approx([0.0, 0.2, 0.0])
    assert frames.between("base_link", "camera") is None
    assert frame_name("/laser ") == "laser"


def test_a_ring_of_frames_ends():
    frames = TransformTree()
    for parent, child in (("a", "b"), ("b", "c"), ("c", "a")):
        frames.add(tf(parent, child))
    assert frames.between("elsewhere", "a") is None


@pytest.mark.parametrize("bad", [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0)])
def test_a_transform_that_says_nothing_is_none(bad):
    x, y, z, w = bad
    assert Rigid3.of(Object(x=0.0, y=0.0, z=0.0), Object(x=x, y=y, z=z, w=w)) is None


def test_odometry_is_interpolated_and_turns_the_short_way():
    track = OdometryTrack.of([1.0, 2.0], [Pose2(0.0, 0.0, 3.0), Pose2(1.0, 2.0, -3.0)])
    between = track.at(1.5)
    assert (between.x, between.y) == pytest.approx((0.5, 1.0))
    assert abs(between.theta) == pytest.approx(math.pi, abs=1e-9)
    assert track.at(2.0).x == 1.0
    assert track.at(2.05).x == 1.0
    assert track.at(0.95).x == 0.0
    assert track.at(2.5) is None
    assert track.at(0.5) is None


def test_odometry_is_not_interpolated_over_a_wide_gap():
    assert OdometryTrack.of([2.0, 9.0], [Pose2(), Pose2()]).at(5.0) is None


def test_odometry_that_is_not_finite_or_does_not_rise_is_counted(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        given = ((1.0, 0.0), (1.0, 0.0), (0.5, 0.0), (1.1, math.nan), (1.2, 0.0))
        for logged, (stamp, x) in enumerate(given):
            bag.odometry(stamp, Pose2(x), logged=1 + 0.1 * logged)
        bag.scan(1.1, [1.0, 1.0], first=0.0, step=0.1)
    found, left_out = read(tmp_path / "bag")
    assert len(found) == 1
    assert left_out.odometry == 3


def read(path):
    return paired(path)[:2]


def test_stamps_that_jump_back_are_left_out_and_counted(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for tick, stamp in enumerate([10.0, 10.1, 10.2, 3.0, 3.1, 10.3]):
            logged = 1 + 0.1 * tick
            bag.odometry(stamp, Pose2(stamp), logged=logged)
            bag.scan(stamp, [1.0, 1.0], first=0.0, step=0.1, logged=logged)
    found, left_out = read(tmp_path / "bag")
    assert [one.scan.stamp for one in found] == pytest.approx([10.0, 10.1, 10.2, 10.3])
    assert (left_out.out_of_order, left_out.odometry) == (2, 2)
    assert "2 scans whose stamps do not rise were left out" in left_out.lines()


@pytest.mark.parametrize("wrong", [1e6, -1e6])
def test_one_stamp_from_elsewhere_makes_no_other_too_old(tmp_path, wrong):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for tick in range(20):
            logged = 2e6 + 0.1 * tick
            stamp = logged + (wrong if tick == 5 else 0.0)
            bag.odometry(stamp, Pose2(0.1 * tick), logged=logged)
            bag.scan(stamp, [1.0, 1.0], first=0.0, step=0.1, logged=logged)
    found, left_out = read(tmp_path / "bag")
    assert [round(10 * (one.scan.stamp - 2e6)) for one in found] == [*range(5), *range(6, 20)]
    assert (left_out.out_of_order, left_out.odometry) == (1, 1)


def test_a_clock_that_was_set_is_followed(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for tick in range(40):
            logged = 2e6 + 0.1 * tick
            stamp = logged + (1e6 if tick >= 10 else 0.0)
            bag.odometry(stamp, Pose2(0.1 * tick), logged=logged)
            bag.scan(stamp, [1.0, 1.0], first=0.0, step=0.1, logged=logged)
    found, left_out = read(tmp_path / "bag")
    assert len(found) == 40
    assert left_out.lines() == []


def test_a_scan_waits_for_the_odometry_after_it(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        bag.odometry(1.0, Pose2(0.0))
        bag.scan(1.5, [1.0, 1.0], first=0.0, step=0.1)
        bag.odometry(2.0, Pose2(1.0))
        bag.scan(5.0, [1.0, 1.0], first=0.0, step=0.1)
    found, left_out = read(tmp_path / "bag")
    assert [one.odom_from_robot.x for one in found] == pytest.approx([0.5])
    assert left_out.without_odometry == 1


def test_a_message_without_a_stamp_counts_from_when_it_was_recorded(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        for logged in (7.0, 7.1, 7.2):
            bag.odometry(0.0, Pose2(logged), logged=logged)
            bag.scan(0.0, [1.0, 1.0], first=0.0, step=0.1, logged=logged)
    found, _ = read(tmp_path / "bag")
    assert [one.scan.stamp for one in found] == pytest.approx([7.0, 7.1, 7.2])


def test_of_several_odometries_the_usual_one_is_taken(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        bag.odometry(1.0, Pose2(), topic="/odometry/filtered")
        bag.odometry(1.0, Pose2(), topic="/odom")
        bag.scan(1.0, [1.0, 1.0], first=0.0, step=0.1)
    with Bag(tmp_path / "bag") as opened:
        assert choose(opened).odometry == "/odom"
        assert choose(opened, odometry="odometry/filtered").odometry == "/odometry/filtered"


def test_transforms_that_never_lead_to_odometry_are_listed(tmp_path):
    with LaserBag(tmp_path / "bag", "mcap") as bag:
        bag.transform(1.0, "body", "laser", Pose2())
        bag.scan(1.0, [1.0, 1.0], first=0.0, step=0.1)
    with (
        Bag(tmp_path / "bag") as opened,
        pytest.raises(BagError, match="there are body - laser"),
    ):
        find_layout(opened, choose(opened), None)


def test_messages_of_foreign_types_do_not_matter(tmp_path):
    """Also such whose definition nobody can read."""
    with LaserBag(tmp_path / "bag", "sqlite3") as bag:
        bag.odometry(1.0, Pose2())
        bag.scan(1.0, [1.0, 1.0], first=0.0, step=0.1)
        odd = bag._writer.add_connection(
            "/odd", "vendor_msgs/msg/Odd", msgdef="this is no definition", rihs01="RIHS01_00"
        )
        bag._writer.write(odd, 2_000_000_000, b"\x00\x01\x00\x00odd")
    found, _ = read(tmp_path / "bag")
    assert len(found) == 1


def test_a_bag_with_fewer_messages_than_its_metadata_has_is_told(tmp_path):
    with LaserBag(tmp_path / "whole", "sqlite3") as bag:
        bag.scan(0.0, [1.0], first=0.0, step=0.1)
        bag.odometry(0.0, Pose2())
    with LaserBag(tmp_path / "hollow", "sqlite3") as bag:
        bag.odometry(0.0, Pose2())
    (tmp_path / "hollow" / "hollow.db3").replace(tmp_path / "whole" / "whole.db3")
    with (
        Bag(tmp_path / "whole") as bag,
        pytest.raises(BagError, match="has no sensor_msgs/msg/LaserScan; it has /odom"),
    ):
        choose(bag)
