"""The messages of the topics, against the snapshots that they were made of."""

import json
import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from engine_runs import EIGHT, kinematic, run
from hypothesis import given
from hypothesis import strategies as st
from journeys import goal
from ros_messages import topic
from scipy.spatial.transform import Rotation

from app.engine.problems import ProblemState
from app.features.ros.links import PlacedLink
from app.features.ros.message_types import from_cdr, message_class, to_cdr
from app.features.ros.source import TopicSource
from app.features.ros.topics import TOPICS, Published
from app.messages.commands import PingCommand, SetPoseCommand
from robot.localization.estimate import Alert, Cause, Integrity, State


@pytest.fixture(scope="module")
def program():
    return kinematic()


@pytest.fixture(scope="module")
def source(program):
    return TopicSource.of(program)


@pytest.fixture(scope="module")
def ticks(program, source):
    """Two seconds of the figure-eight; then a tick is told a goal, and one a pose."""
    found = run(program, 2.0, EIGHT)
    pose = SetPoseCommand(type="set_pose", x=0.1, y=-0.05, theta=0.3, sd_xy=0.02, sd_theta=0.1)
    found += run(program, 0.02, goal(0.1, -0.05, 0.3))
    found += run(program, 0.02, PingCommand(type="ping"), pose)
    found += run(program, 0.02, EIGHT)
    source.clock.follow(found[0])
    return found


@pytest.fixture(scope="module")
def said(source, ticks):
    """The last message of a topic, its stamp, and the tick that it was made of."""

    def last(name):
        one = topic(name)
        for tick in reversed(ticks):
            stamp = one.stamp(tick)
            if stamp is not None:
                return Published(one, stamp, source, tick), tick
        raise AssertionError(f"{name} has never been told")

    return last


def seconds(source, stamp) -> float:
    """A ROS time as the robot's."""
    return (stamp.sec * 10**9 + stamp.nanosec - source.clock.ns(0.0)) / 1e9


def flat(pose) -> list[float]:
    return [
        pose.position.x,
        pose.position.y,
        2 * math.atan2(pose.orientation.z, pose.orientation.w),
    ]


SILENT = {"battery_state", "plan"} | {one.name for one in TOPICS if one.only_dds}
"""The kinematic robot measures no voltage, and nobody sends it anywhere."""


@pytest.mark.slow
@pytest.mark.parametrize("name", [one.name for one in TOPICS if one.name not in SILENT])
def test_bytes_and_object_are_the_same_message(said, name):
    published, _ = said(name)
    kind = published.topic.type
    assert isinstance(published.message, message_class(kind))
    assert to_cdr(from_cdr(published.cdr, kind), kind) == published.cdr
    assert to_cdr(published.message, kind) == published.cdr


def test_a_scan_is_where_the_scanner_found_tape(said, source):
    published, tick = said("scan")
    scan, told = tick.filter.line_scan.scan, published.message
    bearings = told.angle_min + told.angle_increment * np.arange(len(told.ranges))
    np.testing.assert_allclose(bearings, scan.bearings, atol=1e-6)
    np.testing.assert_allclose(told.ranges, scan.ranges, rtol=1e-6)
    assert np.isinf(told.ranges).any() == np.isinf(scan.ranges).any()
    assert seconds(source, told.header.stamp) == pytest.approx(scan.stamp, abs=1e-6)
    assert told.header.frame_id == "base_scan"
    within = told.ranges[np.isfinite(told.ranges)]
    assert (within >= told.range_min).all() and (within <= told.range_max).all()


def test_odometry_tells_pose_and_speed(said, source):
    published, tick = said("odom")
    told = published.message
    np.testing.assert_allclose(flat(told.pose.pose), tick.odom_from_robot.to_array(), atol=1e-12)
    measured = source.robot(tick).drive.twist(tick.reading.velocities)
    assert told.twist.twist.linear.x == pytest.approx(measured.v)
    assert told.twist.twist.angular.z == pytest.approx(measured.omega)
    assert (told.header.frame_id, told.child_frame_id) == ("odom", "base_footprint")


def test_transforms_lead_from_the_map_to_every_link(said, source):
    published, tick = said("tf")
    static, _ = said("tf_static")
    found = {
        t.child_frame_id: t for t in (*published.message.transforms, *static.message.transforms)
    }
    for frame in ("base_scan", source.robot(tick).links.camera, "left_wheel", "right_wheel"):
        way = [frame]
        while way[-1] in found:
            way.append(found[way[-1]].header.frame_id)
        assert way[-4:][-3:] == ["base_footprint", "odom", "map"]
    map_from_odom, odom_from_robot = (found[name].transform for name in ("odom", "base_footprint"))

    def matrix(one):
        turn = one.rotation
        whole = np.eye(4)
        whole[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
        whole[:3, 3] = one.translation.x, one.translation.y, one.translation.z
        return whole

    robot = matrix(map_from_odom) @ matrix(odom_from_robot)
    np.testing.assert_allclose(robot[:2, 3], [tick.pose.x, tick.pose.y], atol=1e-9)
    assert math.atan2(robot[1, 0], robot[0, 0]) == pytest.approx(tick.pose.theta, abs=1e-9)


def test_another_localization_may_tell_where_odometry_is(source, ticks):
    quiet = replace(source, settings=replace(source.settings, tf_broadcast=False))
    published = Published(topic("tf"), 0.0, quiet, ticks[-1])
    children = {one.child_frame_id for one in published.message.transforms}
    assert children == {"base_footprint", "left_wheel", "right_wheel"}


def test_the_camera_is_where_the_description_has_it(said, source):
    static, tick = said("tf_static")
    placed = {t.child_frame_id: t for t in static.message.transforms}
    frame, way = source.robot(tick).links.camera, np.eye(4)
    while frame != "base_footprint":
        one = placed[frame]
        turn, place = one.transform.rotation, one.transform.translation
        step = np.eye(4)
        step[:3, :3] = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).as_matrix()
        step[:3, 3] = place.x, place.y, place.z
        way, frame = step @ way, one.header.frame_id
    np.testing.assert_allclose(way, tick.spec.robot_from_camera, atol=1e-9)


@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1),
    st.lists(st.floats(-1, 1), min_size=3, max_size=3).filter(lambda a: np.linalg.norm(a) > 0.1),
    st.floats(-100, 100),
)
def test_a_wheel_turns_about_its_axis(turn, axis, angle):
    mounted, axis = Rotation.from_quat(turn), np.array(axis) / np.linalg.norm(axis)
    wheel = PlacedLink("hub", "wheel", (0.0, 0.0, 0.0), tuple(mounted.as_quat()), tuple(axis))
    expected = mounted * Rotation.from_rotvec(angle * axis)
    assert (Rotation.from_quat(wheel.turned(angle)) * expected.inv()).magnitude() < 1e-7


def test_joints_are_told_as_they_were_read(said, source):
    published, tick = said("joint_states")
    told = published.message
    assert list(told.name) == [joint.name for joint in tick.spec.joints]
    np.testing.assert_array_equal(told.position, tick.reading.positions)
    np.testing.assert_array_equal(told.velocity, tick.reading.velocities)


def test_the_estimate_has_its_own_stamp_and_covariance(said, source):
    published, tick = said("amcl_pose")
    told = published.message
    np.testing.assert_allclose(flat(told.pose.pose), tick.estimate.pose.to_array(), atol=1e-12)
    whole = told.pose.covariance.reshape(6, 6)
    np.testing.assert_array_equal(whole[np.ix_([0, 1, 5], [0, 1, 5])], tick.estimate.covariance)
    assert seconds(source, told.header.stamp) == pytest.approx(tick.estimate.stamp, abs=1e-6)


def test_clouds_are_a_fair_part_of_the_filters(said, source):
    (weighted, tick), (plain, _) = said("particle_cloud"), said("particlecloud")
    particles, poses = weighted.message.particles, plain.message.poses
    assert len(particles) == len(poses) == source.settings.most_particles
    assert sum(one.weight for one in particles) == pytest.approx(1)
    np.testing.assert_array_equal(
        [flat(one.pose) for one in particles], [flat(one) for one in poses]
    )
    mine = np.array([flat(one.pose) for one in particles])
    of_filter = {tuple(np.round(pose, 9)) for pose in tick.filter.cloud.poses[:, :2]}
    assert all(tuple(np.round(pose[:2], 9)) in of_filter for pose in mine)


def test_an_empty_frame_name_still_aligns_the_cloud(ticks, source):
    for name in ("", "m", "ma", "map", "map_", "map__", "map___", "map____"):
        named = replace(source, settings=replace(source.settings, global_frame_id=name))
        published = Published(topic("particle_cloud"), 0.0, named, ticks[-1])
        assert to_cdr(published.message, published.topic.type) == published.cdr


def test_the_map_is_the_field(said, program, source):
    published, _ = said("map")
    told, grid = published.message, program.field.occupancy(source.settings.map_resolution)
    assert (told.info.height, told.info.width) == grid.data.shape
    np.testing.assert_array_equal(told.data, grid.data.ravel())
    assert told.info.resolution == pytest.approx(grid.resolution)
    np.testing.assert_allclose(flat(told.info.origin), grid.origin.to_array(), atol=1e-12)


def test_a_picture_is_a_jpeg_of_the_frame_with_its_lens(said, source):
    (picture, tick), (lens, _) = said("camera/image/compressed"), said("camera/camera_info")
    shown = cv2.imdecode(np.asarray(picture.message.data), cv2.IMREAD_UNCHANGED)
    assert shown.shape == tick.reading.frame.image.shape
    assert np.abs(shown.astype(int) - tick.reading.frame.image).mean() < 3
    assert picture.message.format.startswith("mono8; jpeg")
    np.testing.assert_array_equal(lens.message.k.reshape(3, 3), tick.spec.lens.matrix)
    np.testing.assert_array_equal(lens.message.d, tick.spec.lens.distortion)
    assert lens.message.header.stamp == picture.message.header.stamp
    assert seconds(source, picture.message.header.stamp) == pytest.approx(tick.reading.frame.stamp)


def test_the_truth_and_the_description_are_told(said, source):
    truth, tick = said("truth")
    np.testing.assert_allclose(flat(truth.message.pose), tick.truth.to_array(), atol=1e-12)
    assert said("robot_description")[0].message.data == tick.spec.urdf


def test_what_was_told_can_be_told_again(said):
    commands, _ = said("initialpose")
    told = commands.message
    np.testing.assert_allclose(flat(told.pose.pose), [0.1, -0.05, 0.3], atol=1e-12)
    np.testing.assert_allclose(told.pose.covariance[[0, 7, 35]], [4e-4, 4e-4, 1e-2])


def test_commands_are_told_in_their_order_but_pings(ticks, source):
    one = topic("command")
    published = Published(one, one.stamp(ticks[-2]), source, ticks[-2])
    assert [c["type"] for c in json.loads(published.message.data)] == ["set_pose"]


def test_the_speed_is_what_was_applied(said):
    published, tick = said("cmd_vel")
    twist = published.message.twist
    assert (twist.linear.x, twist.angular.z) == (tick.twist.v, tick.twist.omega)


def test_diagnostics_say_what_is_wrong(ticks, source):
    wrong = replace(ticks[-1], problems=ProblemState(("The camera sends no pictures.",), 1, ()))
    published = Published(topic("diagnostics"), 0.0, source, wrong)
    first = published.message.status[0]
    assert (first.level, first.message) == (1, "The camera sends no pictures.")
    assert published.message.status[1].level == 0


ASKEW = Alert(Cause.CAMERA_ASKEW, "rays fit 6 mm short on the left: is the camera askew?")


@pytest.mark.parametrize(
    ("claimed", "level", "words"),
    [
        (Integrity(State.CERTAIN, 0.003, 0.01), 0, "certain"),
        (Integrity(State.CERTAIN, 0.018, 0.01, (ASKEW,)), 1, f"certain: {ASKEW.text}"),
        (Integrity(State.APPROXIMATE, 0.06, 0.2), 0, "approximate"),
        (Integrity(State.APPROXIMATE, 0.06, 0.2, (ASKEW,)), 1, f"approximate: {ASKEW.text}"),
        (Integrity(State.AMBIGUOUS), 1, "ambiguous"),
        (Integrity(State.SEARCHING), 1, "searching"),
        (Integrity(State.LOST, alerts=(ASKEW,)), 2, f"lost: {ASKEW.text}"),
    ],
)
def test_diagnostics_say_how_far_the_estimate_may_be_relied_on(
    ticks, source, claimed, level, words
):
    tick = replace(ticks[-1], integrity=claimed)
    published = Published(topic("diagnostics"), 0.0, source, tick)
    status = published.message.status[2]
    assert (status.name, status.level, status.message) == ("brickpose: localization", level, words)
    figures = {one.key: one.value for one in status.values}
    assert figures["state"] == claimed.state
    assert float(figures["radius_m"]) == pytest.approx(claimed.radius, rel=1e-4)
    assert float(figures["heading_bound_rad"]) == pytest.approx(claimed.heading_bound, rel=1e-4)
    assert figures["causes"] == "; ".join(one.cause for one in claimed.alerts)


def test_a_voltage_is_told_where_it_is_measured(ticks, source):
    one = topic("battery_state")
    assert one.stamp(ticks[-1]) is None
    charged = replace(ticks[-1], battery_v=7.4)
    published = Published(one, one.stamp(charged), source, charged)
    assert published.message.voltage == pytest.approx(7.4)
    assert math.isnan(published.message.current)
    assert to_cdr(from_cdr(published.cdr, one.type), one.type) == published.cdr
