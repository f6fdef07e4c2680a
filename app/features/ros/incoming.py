"""The list of all commands that arrive by topic or service, and how each is converted."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.features.mapping.messages import (
    NoMapError,
    PauseMapCommand,
    SaveMapCommand,
    StartMapCommand,
)
from app.features.navigation.messages import GoalMessage, NavigateCommand
from app.features.ros.encoding.frames import SECOND_NS, heading_of
from app.features.ros.message_types import Message, MessageError
from app.features.ros.source import TopicSource
from app.messages.commands import Command, ScatterCommand, SetPoseCommand, UpdateCommand
from app.messages.driving_commands import DriveCommand
from robot.errors import CommandError

TWIST = "geometry_msgs/msg/Twist"
STAMPED_TWIST = "geometry_msgs/msg/TwistStamped"
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"

NO_MAP, FAILURE = 1, 255
"""Results of slam_toolbox's SaveMap."""
LEVEL = 0.1
"""Largest tilt of a pose on the floor [rad]."""


@dataclass(frozen=True, slots=True)
class IncomingTopic:
    """A topic that the robot subscribes to."""

    name: str
    """Without a leading slash."""
    type: str
    command: Callable[[TopicSource, Message], Command]
    """Converts a message to a command.

    Raises:
        MessageError, ValueError: the message is not a valid command; says why.
    """


Answer = dict[str, Any]
"""The fields of a service's answer."""


def cure_of_type(topic: str, type_name: str, type_wanted: str) -> str:
    """Return what makes the robot take cmd_vel in a type; empty if nothing does."""
    if topic != "cmd_vel" or {type_name, type_wanted} != {TWIST, STAMPED_TWIST}:
        return ""
    return f"; [ros2] stamped_cmd_vel = {str(type_wanted == STAMPED_TWIST).lower()} takes it"


def no_fields(refusal: CommandError | None) -> Answer:
    """Answer with nothing; a refusal is an error of the call."""
    if refusal is not None:
        raise refusal
    return {}


@dataclass(frozen=True, slots=True)
class Service:
    """A service that the robot offers."""

    name: str
    type: str
    """As ``std_srvs/srv/Empty``."""
    command: Callable[[TopicSource, Message], Command] | None
    """Converts a request to a command; raises the same errors as that of a topic. None is the
    service that commands nothing, and answers with a plan."""
    answer: Callable[[CommandError | None], Answer] = no_fields
    """Returns the answer, by why the command was refused; or raises that."""
    slow: bool = False
    """Whether it may take more than some milliseconds: the answer then comes from a thread."""


def drive(source: TopicSource, message: Message) -> DriveCommand:
    """Convert a geometry_msgs/Twist unchanged; the drive limits apply later."""
    parts = {
        "linear.x": message.linear.x,
        "linear.y": message.linear.y,
        "linear.z": message.linear.z,
        "angular.x": message.angular.x,
        "angular.y": message.angular.y,
        "angular.z": message.angular.z,
    }
    for name, value in parts.items():
        if not math.isfinite(value):
            raise MessageError(f"cmd_vel: {name} is {value}; valid is a number")
        if value and name not in ("linear.x", "angular.z"):
            raise MessageError(
                f"cmd_vel: {name} is {value:g}; a robot on two wheels can do linear.x and angular.z"
            )
    return DriveCommand(type="drive", v=parts["linear.x"], omega=parts["angular.z"])


def drive_stamped(source: TopicSource, message: Message) -> DriveCommand:
    """Convert a TwistStamped with a recent stamp; zero means now, as in diff_drive_controller."""
    stamp = message.header.stamp
    sent = stamp.sec * SECOND_NS + stamp.nanosec
    age = source.clock.age(sent)
    if sent and abs(age) > source.timeout:
        raise MessageError(
            f"cmd_vel: its stamp is {abs(age):.3g} s {'old' if age > 0 else 'ahead'}; valid is "
            f"{source.timeout:g} s, by this computer's clock (are the clocks set alike?), or zero"
        )
    return drive(source, message.twist)


def set_pose(source: TopicSource, message: Message) -> SetPoseCommand:
    """Convert a PoseWithCovarianceStamped in the map frame, as RViz sends it."""
    _require_map(source, "initialpose", message)
    position, turn = message.pose.pose.position, message.pose.pose.orientation
    whole = np.asarray(message.pose.covariance, dtype=np.float64).reshape(6, 6)
    flat = whole[np.ix_([0, 1, 5], [0, 1, 5])]
    numbers = [position.x, position.y, turn.x, turn.y, turn.z, turn.w, *flat.ravel().tolist()]
    if not all(math.isfinite(value) for value in numbers):
        raise MessageError("initialpose has numbers that are not finite")
    return SetPoseCommand(
        type="set_pose",
        x=position.x,
        y=position.y,
        theta=_heading("initialpose", turn),
        # Without a covariance, the default uncertainty is used.
        covariance=flat.ravel().tolist() if flat.any() else None,
    )


def goal_of(source: TopicSource, name: str, message: Message) -> GoalMessage:
    """Convert a PoseStamped in the map frame to a goal; messages of errors have a name.

    Raises:
        MessageError: it is of another frame, or not a pose on the floor.
    """
    _require_map(source, name, message)
    position, turn = message.pose.position, message.pose.orientation
    if not all(map(math.isfinite, (position.x, position.y, turn.x, turn.y, turn.z, turn.w))):
        raise MessageError(f"{name} has numbers that are not finite")
    return GoalMessage(x=position.x, y=position.y, theta=_heading(name, turn))


def _go_to(source: TopicSource, message: Message) -> NavigateCommand:
    return NavigateCommand(type="navigate", poses=[goal_of(source, "goal_pose", message)])


def _require_map(source: TopicSource, name: str, message: Message) -> None:
    frame, wanted = message.header.frame_id.lstrip("/"), source.settings.global_frame_id
    if frame not in ("", wanted):
        raise MessageError(f"{name}: its frame is {frame!r}; valid is {wanted!r}")


def _heading(name: str, turn: Message) -> float:
    """The heading of a quaternion that rotates about z [rad]."""
    length = math.hypot(turn.x, turn.y, turn.z, turn.w)
    if length < 0.5:
        raise MessageError(f"{name}: its orientation is no quaternion of length 1")
    if 2 * math.asin(min(1.0, math.hypot(turn.x, turn.y) / length)) > LEVEL:
        raise MessageError(f"{name}: its orientation leans; valid is a turn about z")
    return heading_of(turn)


def _scatter(source: TopicSource, request: Message) -> ScatterCommand:
    return ScatterCommand(type="scatter")


def _update(source: TopicSource, request: Message) -> UpdateCommand:
    return UpdateCommand(type="update")


def _requested_pose(source: TopicSource, request: Message) -> SetPoseCommand:
    return set_pose(source, request.pose)


def _save_map(source: TopicSource, request: Message) -> SaveMapCommand:
    # As nav2's map saver names maps.
    return SaveMapCommand(type="save_map", name=request.name.data or f"map_{int(time.time())}")


def _saved(refusal: CommandError | None) -> Answer:
    if refusal is None:
        return {"result": 0}
    return {"result": NO_MAP if isinstance(refusal, NoMapError) else FAILURE}


def _pause_map(source: TopicSource, request: Message) -> PauseMapCommand:
    return PauseMapCommand(type="pause_map")


def _reset_map(source: TopicSource, request: Message) -> StartMapCommand:
    paused = bool(request.pause_new_measurements)
    return StartMapCommand(type="start_map", discard=True, paused=paused)


INCOMING: tuple[IncomingTopic, ...] = (
    IncomingTopic("cmd_vel", STAMPED_TWIST, drive_stamped),
    IncomingTopic("cmd_vel", TWIST, drive),
    IncomingTopic("initialpose", POSE, set_pose),
    IncomingTopic("goal_pose", "geometry_msgs/msg/PoseStamped", _go_to),
)
"""All topics; a setting chooses one of the two types of cmd_vel."""

SERVICES: tuple[Service, ...] = (
    Service("reinitialize_global_localization", "std_srvs/srv/Empty", _scatter),
    Service("request_nomotion_update", "std_srvs/srv/Empty", _update),
    Service("set_initial_pose", "nav2_msgs/srv/SetInitialPose", _requested_pose),
    Service("compute_path_to_pose", "nav_msgs/srv/GetPlan", None, slow=True),
    Service("slam_toolbox/save_map", "slam_toolbox/srv/SaveMap", _save_map, _saved, slow=True),
    Service(
        "slam_toolbox/pause_new_measurements",
        "slam_toolbox/srv/Pause",
        _pause_map,
        lambda refusal: {"status": refusal is None},
    ),
    Service(
        "slam_toolbox/reset",
        "slam_toolbox/srv/Reset",
        _reset_map,
        lambda refusal: {**no_fields(refusal), "result": 0},
        slow=True,
    ),
)
