"""Commands that come as messages: what they mean, and what is refused."""

import math
import time

import numpy as np
import pytest
from engine_runs import kinematic, run
from hypothesis import given
from hypothesis import strategies as st

from app.engine.drivers import Driver, Drivers
from app.features.ros.encoding.frames import pose_with_covariance, turned, vector
from app.features.ros.encoding.frames import time as ros_time
from app.features.ros.inbox import Inbox
from app.features.ros.message_types import MessageError, new, to_cdr
from app.features.ros.source import TopicSource
from app.messages.commands import ScatterCommand, SetPoseCommand, UpdateCommand
from app.messages.driving_commands import DriveCommand
from app.settings.groups import Ros2Settings
from robot.errors import CommandError
from robot.geometry import Pose2

STAMPED, PLAIN = "geometry_msgs/msg/TwistStamped", "geometry_msgs/msg/Twist"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"


def header(stamp_ns=0, frame=""):
    return new("std_msgs/msg/Header", stamp=ros_time(stamp_ns), frame_id=frame)


def twist(v=0.0, omega=0.0, **other):
    linear, angular = vector(v, other.get("y", 0.0)), vector(0.0, other.get("wy", 0.0), omega)
    return new(PLAIN, linear=linear, angular=angular)


def stamped(v=0.0, omega=0.0, stamp_ns=0, **other):
    return new(STAMPED, header=header(stamp_ns), twist=twist(v, omega, **other))


def pose(x=0.1, y=0.2, theta=0.3, frame="map", covariance=None):
    at = pose_with_covariance(Pose2(x, y, theta), np.zeros((3, 3)))
    if covariance is not None:
        at.covariance[:] = covariance
    return new(POSE, header=header(0, frame), pose=at)


@pytest.fixture
def program():
    program = kinematic()
    run(program, 0.1)
    return program


ME = Driver("ROS 2")


def inbox_of(program) -> Inbox:
    return Inbox(program, TopicSource.of(program), Drivers.of(program))


@pytest.fixture
def inbox(program):
    return inbox_of(program)


def test_cmd_vel_drives(program, inbox):
    inbox.take("cmd_vel", STAMPED, stamped(0.1, 0.2), ME)
    (last,) = run(program, 0.02)
    assert last.commands == (DriveCommand(type="drive", v=0.1, omega=0.2),)
    assert run(program, 0.25)[-1].twist.v == pytest.approx(0.1)


def test_bytes_are_as_good(program, inbox):
    inbox.take("cmd_vel", STAMPED, to_cdr(stamped(0.1), STAMPED), ME)
    assert run(program, 0.02)[0].commands[0].v == 0.1


def test_the_type_of_cmd_vel_is_a_setting(program):
    old = kinematic(ros2=Ros2Settings(stamped_cmd_vel=False))
    inbox = inbox_of(old)
    assert inbox.take("cmd_vel", PLAIN, twist(0.1), ME) == DriveCommand(
        type="drive", v=0.1, omega=0.0
    )
    with pytest.raises(MessageError, match=r"cmd_vel \(geometry_msgs/msg/Twist\)"):
        inbox.take("cmd_vel", STAMPED, stamped(0.1), ME)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("message", "words"),
    [
        (stamped(math.nan), "linear.x is nan; valid is a number"),
        (stamped(0.1, math.inf), "angular.z is inf"),
        (stamped(0.1, y=0.2), "linear.y is 0.2; a robot on two wheels"),
        (stamped(0.1, wy=0.2), "angular.y is 0.2"),
        (stamped(11.0), "less than or equal to 10"),
        (stamped(0.1, stamp_ns=10**9), "s old; valid is 0.3 s"),
        (b"\0\1\0\0junk", "are no geometry_msgs/msg/TwistStamped"),
    ],
)
def test_what_cannot_be_driven_is_refused_and_stops_the_robot(program, inbox, message, words):
    inbox.take("cmd_vel", STAMPED, stamped(0.2), ME)
    assert run(program, 0.3)[-1].twist.v > 0
    with pytest.raises(ValueError, match=words):
        inbox.take("cmd_vel", STAMPED, message, ME)
    assert run(program, 0.2)[-1].twist.v == 0


def test_a_stamp_ahead_of_us_is_refused_too(inbox):
    with pytest.raises(MessageError, match="ahead"):
        inbox.take("cmd_vel", STAMPED, stamped(0.1, stamp_ns=time.time_ns() + 10**10), ME)


def test_a_fresh_stamp_is_taken(inbox):
    inbox.take("cmd_vel", STAMPED, stamped(0.1, stamp_ns=time.time_ns()), ME)


def test_the_wrong_type_is_answered_with_the_right_one(inbox):
    right = r"valid are cmd_vel \(geometry_msgs/msg/TwistStamped\).*_cmd_vel = false takes it"
    with pytest.raises(MessageError, match=right):
        inbox.take("cmd_vel", PLAIN, twist(0.1), ME)
    with pytest.raises(MessageError, match=r"goal_pose .* is not listened to"):
        inbox.take("goal_pose", POSE, pose(), ME)


def test_a_pose_is_told(inbox):
    command = inbox.take("initialpose", POSE, pose(), ME)
    assert isinstance(command, SetPoseCommand)
    assert (command.x, command.y) == (0.1, 0.2)
    assert command.theta == pytest.approx(0.3)
    assert command.covariance is None


def test_a_covariance_is_taken_from_the_floor(inbox):
    whole = np.zeros((6, 6))
    whole[0, 0], whole[1, 1], whole[5, 5] = 0.25, 0.09, 0.07
    whole[0, 5] = whole[5, 0] = 0.01
    command = inbox.take("initialpose", POSE, pose(covariance=whole.ravel()), ME)
    assert command.covariance == [0.25, 0, 0.01, 0, 0.09, 0, 0.01, 0, 0.07]


def leaning():
    message = pose()
    message.pose.pose.orientation.x = 0.5
    return message


def no_quaternion():
    message = pose()
    message.pose.pose.orientation.z = message.pose.pose.orientation.w = 0.0
    return message


@pytest.mark.parametrize(
    ("message", "words"),
    [
        (pose(frame="odom"), "its frame is 'odom'; valid is 'map'"),
        (pose(x=50.0), "off the map"),
        (pose(x=math.nan), "not finite"),
        (pose(covariance=np.full(36, np.inf)), "not finite"),
        (pose(covariance=-np.eye(6).ravel()), "positive semi-definite"),
        (leaning(), "leans"),
        (no_quaternion(), "no quaternion"),
    ],
)
def test_a_pose_that_cannot_be_is_refused(program, inbox, message, words):
    with pytest.raises(ValueError, match=words):
        inbox.take("initialpose", POSE, message, ME)
    assert len(program.engine.commands) == 0


@given(st.floats(-math.pi, math.pi), st.floats(0.6, 2))
def test_any_heading_is_read_back(theta, length):
    from app.features.ros.incoming import _heading

    turn = turned(theta)
    turn.z, turn.w = turn.z * length, turn.w * length
    assert math.remainder(_heading("initialpose", turn) - theta, 2 * math.pi) == pytest.approx(
        0, abs=1e-9
    )


def test_services_do_what_amcl_does(program, inbox):
    empty = new("std_srvs/srv/Empty_Request", structure_needs_at_least_one_member=0)
    told = new("nav2_msgs/srv/SetInitialPose_Request", pose=pose())
    assert inbox.call("reinitialize_global_localization", empty, ME) == {}
    assert inbox.call("request_nomotion_update", empty, ME) == {}
    assert inbox.call("set_initial_pose", told, ME) == {}
    scatter, update, set_pose = run(program, 0.02)[0].commands
    assert isinstance(scatter, ScatterCommand) and isinstance(update, UpdateCommand)
    assert (set_pose.x, set_pose.y) == (0.1, 0.2)
    with pytest.raises(MessageError, match="valid are reinitialize_global_localization"):
        inbox.call("get_map", empty, ME)


def test_a_refusal_is_an_error_of_services_that_cannot_tell_it(program, inbox):
    far = new("nav2_msgs/srv/SetInitialPose_Request", pose=pose())
    far.pose.pose.pose.position.x = 100.0
    with pytest.raises(CommandError, match="off the map"):
        inbox.call("set_initial_pose", far, ME)
