"""What is recorded is what happened, as three readers that are not ours have it."""

import json
import math
import re
from dataclasses import replace

import cv2
import numpy as np
import pytest
from engine_runs import EIGHT, kinematic, run
from journeys import RENEW, goal
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from node_peers import needs_node, run_node
from recordings import begin, recorder_of
from rosbags.highlevel import AnyReader

from app.features.ros.topics import TOPICS
from app.messages.commands import SetPoseCommand
from app.settings.config import ROOT
from robot.geometry import Pose2
from sim.simulated import PERIOD

GOAL = goal(0.1, -0.05, 0.3)
"""Given in the recording; the figure-eight is then driven on."""
PLANS = 60, 106
"""In these ticks the robot stops, and the way to the goal is planned."""
TOLD = SetPoseCommand(type="set_pose", x=0.01, y=0.02, theta=0.3, sd_xy=0.1, sd_theta=0.2)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """The recording's folder, the snapshots by their time, and the program."""
    program = kinematic(seed=5)
    run(program, 0.5, EIGHT)
    recorder, publisher = recorder_of(program, tmp_path_factory.mktemp("recordings"))
    folder = begin(recorder, publisher)
    shown = {}
    for tick in range(round(2.2 / PERIOD)):
        if tick == 40:
            program.engine.commands.put(TOLD)
        if tick == PLANS[0]:
            program.engine.commands.put(GOAL)
        way = RENEW if PLANS[0] <= tick < PLANS[1] else EIGHT
        snapshot = replace(run(program, PERIOD, way)[0], battery_v=7.5 + tick / 1000)
        publisher.tick(snapshot)
        shown[publisher.source.clock.ns(snapshot.stamp)] = snapshot
    recorder.close()
    assert recorder.status.message is None
    return folder, shown, program


def plain(value):
    """Any reader's message as dictionaries, lists and numbers; what JSON has not is by name."""
    if isinstance(value, float) and not math.isfinite(value):
        return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"
    if isinstance(value, str | int | float):
        return value
    if isinstance(value, np.ndarray):
        return plain(value.tolist())
    if isinstance(value, bytes | bytearray | memoryview | list | tuple):
        return [plain(one) for one in value]
    # Constants of a type are in capitals.
    names = getattr(value, "__slots__", None) or vars(value)
    return {
        name: plain(getattr(value, name))
        for name in names
        if name.strip("_").islower() and not name.startswith("_")
    }


@pytest.fixture(scope="module")
def by_rosbags(recorded):
    """Topic, time and message as rosbags has them."""
    with AnyReader([recorded[0]]) as reader:
        return [(c.topic, t, reader.deserialize(d, c.msgtype)) for c, t, d in reader.messages()]


@pytest.fixture(scope="module")
def of_topic(by_rosbags, recorded):
    """The messages of a topic, each with the snapshot of its tick."""

    def of(name):
        return [(m, recorded[1][time]) for topic, time, m in by_rosbags if topic == name]

    return of


def sorted_by_topic(messages):
    return sorted(messages, key=lambda one: (one[0], one[1]))


@pytest.mark.slow
def test_every_topic_is_recorded(by_rosbags):
    kept = {f"/{topic.name}" for topic in TOPICS if not topic.only_dds}
    assert {topic for topic, _, _ in by_rosbags} == kept


def test_mcap_ros2_support_has_the_same_values(recorded, by_rosbags):
    with next(recorded[0].glob("*.mcap")).open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        found = [
            (channel.topic, message.log_time, plain(decoded))
            for _, channel, message, decoded in reader.iter_decoded_messages()
        ]
    ours = [(topic, time, plain(message)) for topic, time, message in by_rosbags]
    assert sorted_by_topic(found) == sorted_by_topic(ours)


@needs_node
def test_foxgloves_packages_have_the_same_values(recorded, by_rosbags):
    lines = run_node("read_mcap.mjs", str(next(recorded[0].glob("*.mcap"))))
    found = [(one["topic"], int(one["log_time"]), one["message"]) for one in lines]
    ours = [(topic, time, plain(message)) for topic, time, message in by_rosbags]
    assert len(found) == len(ours)
    for theirs, mine in zip(sorted_by_topic(found), sorted_by_topic(ours), strict=True):
        assert theirs == mine


def pose_of(message):
    q = message.orientation
    return [message.position.x, message.position.y, 2 * math.atan2(q.z, q.w)]


def close_to(pose, tolerance=1e-9):
    return pytest.approx([pose.x, pose.y, pose.theta], abs=tolerance)


def test_joints_and_velocities_are_recorded_each_tick(of_topic, recorded):
    joints = of_topic("/joint_states")
    assert len(joints) == len(recorded[1])
    for message, snapshot in joints:
        assert message.position.tolist() == snapshot.reading.positions.tolist()
        assert message.velocity.tolist() == snapshot.reading.velocities.tolist()
    velocities = of_topic("/cmd_vel")
    assert len(velocities) == len(recorded[1])
    for message, snapshot in velocities:
        assert message.twist.linear.x == snapshot.twist.v
        assert message.twist.angular.z == snapshot.twist.omega


def test_scans_are_those_of_the_pictures(of_topic):
    scans = of_topic("/scan")
    assert len(scans) > 50
    for message, snapshot in scans:
        scan = snapshot.filter.line_scan.scan
        assert message.ranges.tolist() == scan.ranges.astype(np.float32).tolist()
        assert message.angle_min == pytest.approx(scan.bearings[0], abs=1e-6)


def test_poses_are_those_of_the_ticks(of_topic):
    for message, snapshot in of_topic("/odom"):
        assert pose_of(message.pose.pose) == close_to(snapshot.odom_from_robot)
    for message, snapshot in of_topic("/truth"):
        assert pose_of(message.pose) == close_to(snapshot.truth)
    for message, snapshot in of_topic("/amcl_pose"):
        assert pose_of(message.pose.pose) == close_to(snapshot.estimate.pose)
        covariance = message.pose.covariance.reshape(6, 6)[np.ix_([0, 1, 5], [0, 1, 5])]
        assert covariance == pytest.approx(snapshot.estimate.covariance)
    for message, snapshot in of_topic("/tf"):
        frames = {t.child_frame_id: t.transform for t in message.transforms}
        odom = frames["base_footprint"]
        assert odom.translation.x == pytest.approx(snapshot.odom_from_robot.x)
        map_from_odom = snapshot.pose @ snapshot.odom_from_robot.inverse()
        shift = frames["odom"]
        found = Pose2(
            shift.translation.x,
            shift.translation.y,
            2 * math.atan2(shift.rotation.z, shift.rotation.w),
        )
        assert [found.x, found.y] == pytest.approx([map_from_odom.x, map_from_odom.y], abs=1e-9)


def test_clouds_are_those_of_the_ticks_at_two_hertz(of_topic):
    clouds = of_topic("/particle_cloud")
    assert 4 <= len(clouds) <= 6
    for message, snapshot in clouds:
        places = {
            (round(float(x), 12), round(float(y), 12)) for x, y, _ in snapshot.filter.cloud.poses
        }
        assert len(message.particles) == min(500, len(snapshot.filter.cloud.poses))
        for particle in message.particles:
            position = particle.pose.position
            assert (round(position.x, 12), round(position.y, 12)) in places


def test_pictures_come_at_fifteen_hertz_and_look_as_they_did(of_topic, recorded):
    pictures = of_topic("/camera/image/compressed")
    assert len(pictures) == pytest.approx(2.2 * 15, abs=1)
    lenses = of_topic("/camera/camera_info")
    assert [m.header.stamp for m, _ in lenses] == [m.header.stamp for m, _ in pictures]
    lens = recorded[2].robot.spec.lens
    assert lenses[0][0].k.tolist() == lens.matrix.ravel().tolist()
    for message, snapshot in pictures:
        picture = cv2.imdecode(message.data, cv2.IMREAD_UNCHANGED)
        difference = np.abs(picture.astype(int) - snapshot.reading.frame.image.astype(int))
        assert difference.mean() < 3


def test_what_never_changes_is_recorded_once(of_topic, recorded):
    (described, _), *more = of_topic("/robot_description")
    assert described.data == recorded[2].robot.spec.urdf
    (grid, _), *more_maps = of_topic("/map")
    cells = recorded[2].field.occupancy(0.005).data
    assert grid.data.tolist() == cells.ravel().tolist()
    (transforms, _), *more_transforms = of_topic("/tf_static")
    assert len(transforms.transforms) > 3
    assert not (more or more_maps or more_transforms)


def test_battery_and_health_are_recorded_each_second(of_topic):
    for message, snapshot in of_topic("/battery_state"):
        assert message.voltage == pytest.approx(snapshot.battery_v, rel=1e-6)
        assert math.isnan(message.current)
    message, snapshot = of_topic("/diagnostics")[-1]
    figures = {one.key: one.value for one in message.status[0].values}
    assert figures["step_hz"] == f"{snapshot.loop.step_hz:.1f}"


def test_all_that_the_robot_was_told_is_recorded_with_its_tick(of_topic, recorded):
    told = of_topic("/command")
    assert len(told) == len(recorded[1])  # the figure-eight is renewed each tick
    for message, snapshot in told:
        assert json.loads(message.data) == [
            one.model_dump(mode="json", exclude_none=True) for one in snapshot.commands
        ]
    ((message, snapshot),) = of_topic("/initialpose")
    assert TOLD in snapshot.commands
    assert pose_of(message.pose.pose) == pytest.approx([0.01, 0.02, 0.3])


def test_the_example_of_the_documentation_works(recorded, of_topic, capsys, monkeypatch):
    page = (ROOT / "docs" / "recordings.md").read_text(encoding="utf-8")
    (example,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(recorded[0].parent)
    exec(example.replace('"NAME"', repr(recorded[0].name)), {})
    assert len(capsys.readouterr().out.splitlines()) == len(of_topic("/odom")) > 40


def test_the_documentation_has_every_topic():
    page = (ROOT / "docs" / "recordings.md").read_text(encoding="utf-8")
    assert [one.name for one in TOPICS if f"`/{one.name}`" not in page and not one.only_dds] == []


def test_a_goal_is_as_it_was_given(of_topic):
    ((message, snapshot),) = of_topic("/goal_pose")
    assert GOAL in snapshot.commands
    assert message.header.frame_id == "map"
    assert (message.pose.position.x, message.pose.position.y) == (0.1, -0.05)
    turn = message.pose.orientation
    assert 2 * math.atan2(turn.z, turn.w) == pytest.approx(0.3)
