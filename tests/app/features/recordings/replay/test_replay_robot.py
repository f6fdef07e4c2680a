"""A recording as a robot: what was read then, in order, whatever the file holds."""

from itertools import pairwise

import cv2
import numpy as np
import pytest
from live_topic_bags import GREY, JOINTS, SPEC, Bag, header
from replays import recorded_eight

from app.features.recordings.files.recorded import RecordingError
from app.features.recordings.replay.opening import ReplayOptions, open_replay
from app.features.recordings.replay.position import ReadPosition
from app.features.ros.message_types import new
from app.messages.commands import SetPoseCommand
from robot.driving.differential_drive import DifferentialDrive
from robot.interface import RepositionableRobot, Robot, RobotError


@pytest.fixture
def bag(tmp_path):
    return Bag(tmp_path / "bag")


def readings(robot):
    found = []
    while robot.next_ns is not None:
        found.append(robot.read())
    return found


@pytest.fixture(scope="module")
def eight(tmp_path_factory):
    made, shown = recorded_eight(tmp_path_factory.mktemp("recordings"), seconds=2, picture_rate=0)
    program = open_replay(made, ReplayOptions())
    return program.robot, shown


def test_it_is_a_robot_that_cannot_be_placed(eight):
    robot, _ = eight
    assert isinstance(robot, Robot)
    assert not isinstance(robot, RepositionableRobot)


def test_it_reads_what_was_read_then(eight):
    robot, shown = eight
    robot.go_to(ReadPosition())
    for now, then in zip(readings(robot), shown, strict=True):
        read = then.reading
        assert now.stamp == pytest.approx(then.stamp - shown[0].stamp, abs=1e-6)
        assert now.positions == pytest.approx(read.positions, abs=1e-12)
        assert now.velocities == pytest.approx(read.velocities, abs=1e-12)
        assert (now.frame is None) == (read.frame is None)
        if now.frame is not None:
            exposed = read.frame.stamp - shown[0].stamp
            assert now.frame.stamp == pytest.approx(exposed, abs=1e-6)
            apart = now.frame.image.astype(int) - read.frame.image
            assert np.abs(apart).mean() < 3, "it is a JPEG of that picture"
            assert not now.frame.image.flags.writeable


def test_it_commands_nothing_and_tells_what_was_applied_then(eight):
    robot, shown = eight
    drive = DifferentialDrive(robot.spec)
    robot.go_to(ReadPosition())
    for then in shown:
        robot.read()
        applied = robot.write(np.full(2, 99.0))
        assert applied == pytest.approx(drive.wheels(then.twist), abs=1e-9)


def test_it_goes_on_from_any_place_as_it_did_from_there(eight):
    robot, _ = eight
    robot.go_to(ReadPosition())
    for _ in range(30):
        robot.read()
    place = robot.at
    expected = readings(robot)
    robot.go_to(place)
    again = readings(robot)
    assert [one.stamp for one in again] == [one.stamp for one in expected]
    assert all((a.positions == b.positions).all() for a, b in zip(again, expected, strict=True))


def test_over_is_an_error_of_the_robot_and_close_may_be_called_twice(bag):
    bag.joints(0.0)
    bag.picture(0.0)
    robot = bag.robot()
    robot.read()
    assert robot.next_ns is None
    with pytest.raises(RobotError, match="over"):
        robot.read()
    robot.close()
    robot.close()
    assert not robot.write(np.ones(2)).any()


def test_a_bag_of_live_topics_at_lower_rates_is_read_by_log_time(bag):
    for tick in range(20):
        bag.joints(0.05 * tick, turned=0.1 * tick, logged=0.05 * tick + 0.003)
        if tick % 2:
            bag.picture(0.05 * tick - 0.04, logged=0.05 * tick + 0.001)
    found = readings(bag.robot())
    assert [one.frame is not None for one in found] == [False, True] * 10
    handed = [(one.stamp, one.frame.stamp) for one in found if one.frame is not None]
    assert all(now - then == pytest.approx(0.04, abs=1e-6) for now, then in handed)


def test_topics_may_lie_in_a_namespace(tmp_path):
    bag = Bag(tmp_path / "bag", namespace="/robot1")
    bag.joints(0.0)
    bag.picture(0.0)
    assert bag.robot().read().frame is not None


def test_without_the_topics_needed_it_lists_what_there_is(bag):
    bag.joints(0.0)
    bag.text("chatter", 0.0, "hello")
    with pytest.raises(RecordingError, match=r"no camera/image/compressed .*/chatter \(std_msgs"):
        bag.robot()


def test_joints_of_another_robot_are_named(bag):
    bag.joints(0.0, names=["elbow", "knee"])
    bag.picture(0.0)
    with pytest.raises(RecordingError, match=r"elbow, knee.*this robot's are"):
        bag.robot()


def test_stamps_that_jump_back_are_told_and_time_goes_on(bag):
    for tick in range(10):
        bag.joints(0.02 * tick, turned=0.1 * tick)
    bag.picture(0.0)
    # The clock was set back by 5 s: the wheels go on.
    for tick in range(10, 20):
        bag.joints(0.02 * tick - 5.0, turned=0.1 * tick, logged=0.02 * tick)
    found = readings(bag.robot())
    assert len(found) == 20
    assert all(after.stamp > before.stamp for before, after in pairwise(found))
    assert found[-1].positions == pytest.approx([1.9, 1.9])
    assert not found[9].faults
    assert "jump back by 4.98" in " ".join(found[10].faults)


def test_wheels_that_were_counted_anew_did_not_turn_back(bag):
    for tick in range(10):
        bag.joints(0.02 * tick, turned=500.0 + 0.1 * tick)
    bag.picture(0.0)
    for tick in range(10):
        bag.joints(0.02 * tick - 9.0, turned=0.1 * tick, logged=1.0 + 0.02 * tick)
    turned = np.array([one.positions[0] for one in readings(bag.robot())])
    assert (np.diff(turned) >= 0).all()
    assert turned[-1] - turned[0] == pytest.approx(1.8)


def test_the_same_joints_once_more_are_no_tick_and_what_came_with_them_is_kept(bag):
    bag.joints(0.0)
    bag.picture(0.01)
    bag.joints(0.0, logged=0.02)
    bag.joints(0.04)
    found = readings(bag.robot())
    assert [one.stamp for one in found] == pytest.approx([0.0, 0.04])
    assert found[1].frame is not None


@pytest.mark.parametrize(
    "data", [b"", b"no picture", cv2.imencode(".jpg", GREY[:40, :40])[1].tobytes()]
)
def test_a_picture_that_cannot_be_used_is_told_and_nothing_stops(bag, data):
    bag.joints(0.0)
    bag.picture(0.02, data=np.frombuffer(data, np.uint8))
    bag.joints(0.02)
    bag.picture(0.04)
    bag.joints(0.04)
    found = readings(bag.robot())
    assert found[1].frame is None
    assert "picture" in " ".join(found[1].faults)
    assert found[2].frame is not None


def test_joints_that_are_no_numbers_are_passed_over_and_told(bag):
    bag.joints(0.0)
    bag.picture(0.0)
    bag.joints(0.02, turned=np.nan)
    bag.joints(0.04)
    found = readings(bag.robot())
    assert [one.stamp for one in found] == pytest.approx([0.0, 0.04])
    assert "no numbers" in " ".join(found[1].faults)


def test_a_command_that_nobody_here_has_is_left_out_alone_and_named(bag):
    bag.joints(0.0)
    bag.picture(0.0)
    commands = '[{"type": "dance"}, {"type": "set_pose", "x": 0.1, "y": 0, "theta": 1}]'
    bag.text("command", 0.02, commands)
    bag.joints(0.02)
    robot = bag.robot()
    robot.read()
    assert robot.commands() == (SetPoseCommand(type="set_pose", x=0.1, y=0.0, theta=1.0),)
    assert "no feature here has the command 'dance'" in " ".join(robot.read().faults)


def test_commands_come_in_their_tick(bag):
    bag.joints(0.0)
    bag.picture(0.0)
    bag.text("command", 0.02, '[{"type": "set_pose", "x": 0.1, "y": 0, "theta": 1}]')
    bag.joints(0.02)
    bag.text("command", 0.04, "no command")
    bag.joints(0.04)
    robot = bag.robot()
    assert robot.commands() == ()
    robot.read()
    assert robot.commands() == (SetPoseCommand(type="set_pose", x=0.1, y=0.0, theta=1.0),)
    robot.read()
    assert robot.commands() == ()
    assert "command" in " ".join(robot.read().faults)


def test_velocities_that_were_not_recorded_are_those_of_the_positions(bag):
    for tick in range(3):
        message = new(
            JOINTS,
            header=header(0.02 * tick),
            name=[joint.name for joint in SPEC.joints],
            position=np.array([0.1, -0.2]) * tick,
            velocity=np.empty(0),
            effort=np.empty(0),
        )
        bag.write("joint_states", JOINTS, 0.02 * tick, message)
    bag.picture(0.0)
    assert readings(bag.robot())[-1].velocities == pytest.approx([5.0, -10.0])


def test_a_truth_that_comes_late_is_carried_on_by_the_wheels(bag):
    kind = "geometry_msgs/msg/PoseStamped"
    for tick in range(10):
        bag.joints(0.05 * tick, turned=0.2 * tick)
        if tick == 0:
            bag.picture(0.0)
        point = new("geometry_msgs/msg/Point", x=0.2 * tick * SPEC.wheel_radius, y=0.0, z=0.0)
        straight = new("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0)
        pose = new("geometry_msgs/msg/Pose", position=point, orientation=straight)
        stamped = new(kind, header=header(0.05 * tick), pose=pose)
        bag.write("truth", kind, 0.05 * tick + 0.001, stamped)
    found = readings(bag.robot())[1:]
    expected = [0.2 * tick * SPEC.wheel_radius for tick in range(1, 10)]
    assert [one.truth.x for one in found] == pytest.approx(expected, abs=1e-6)


def test_a_bag_without_a_map_asks_for_one(bag):
    bag.joints(0.0)
    bag.picture(0.0)
    bag.file.close()
    with pytest.raises(RecordingError, match="--map"):
        open_replay(bag.folder, ReplayOptions())
    program = open_replay(bag.folder, ReplayOptions(map="square"))
    replay = program.replay
    assert program.field.name == "square"
    assert replay.duration_s == 0.0
