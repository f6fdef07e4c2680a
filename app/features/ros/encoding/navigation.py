"""Navigation to goals: the way as nav_msgs/Path, and the two topics of nav2's action."""

from __future__ import annotations

import math
import uuid
from collections.abc import Iterable

import numpy as np

from app.engine.snapshot import Snapshot
from app.features.ros.encoding.frames import SECOND_NS, header, pose, time
from app.features.ros.message_types import Message, new
from app.features.ros.source import TopicSource
from robot.geometry import Pose2
from robot.navigation.navigation_status import NavigationStatus

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6
"""Codes of action_msgs/msg/GoalStatus for a goal that is over."""
EXECUTING = 2
"""The same for one that is driven to."""
OVER = {"arrived": SUCCEEDED, "canceled": CANCELED, "failed": ABORTED}
FEEDBACK = "nav2_msgs/action/NavigateToPose_FeedbackMessage"
FEEDBACK_S = 0.2
"""Time between two messages of feedback [s]."""
GOALS = uuid.UUID("f8a2c3e2-6f0a-4d0e-8a53-3a2a2c7fd8b1")
"""A goal's number is made from it and from the time when its journey began."""


def plan_stamp(snapshot: Snapshot) -> float | None:
    """When the way to the goal was planned; None without one."""
    status = snapshot.added.get("navigation")
    return None if status is None or status.path is None else float(status.planned)


def plan(source: TopicSource, snapshot: Snapshot) -> Message:
    """The way to the next goal; each pose looks along it."""
    status = snapshot.added["navigation"]
    steps = np.diff(status.path, axis=0)
    moves = np.hypot(*steps.T) > 1e-9  # it also stands, to turn
    points = np.concatenate([status.path[:-1][moves], status.path[-1:]])
    headings = np.arctan2(*steps[moves].T[::-1])
    last = headings[-1:] if len(headings) else [0.0]
    poses = [
        Pose2(float(x), float(y), float(theta))
        for (x, y), theta in zip(points, [*headings, *last], strict=True)
    ]
    return path_message(source, status.planned, poses)


def path_message(source: TopicSource, stamp: float, poses: Iterable[Pose2]) -> Message:
    """nav_msgs/Path of poses in the map."""
    frame = source.settings.global_frame_id
    position = header(source, stamp, frame)
    return new(
        "nav_msgs/msg/Path",
        header=position,
        poses=[
            new("geometry_msgs/msg/PoseStamped", header=position, pose=pose(each)) for each in poses
        ],
    )


def goal_status_stamp(snapshot: Snapshot) -> float | None:
    """When the state of the newest goal changed; None before the first one."""
    status = _to_goal(snapshot)
    return None if status is None else float(status.since)


def goal_status(source: TopicSource, snapshot: Snapshot) -> Message:
    """action_msgs/GoalStatusArray: the newest goal, whoever sent it."""
    status = snapshot.added["navigation"]
    info = new(
        "action_msgs/msg/GoalInfo",
        goal_id=_goal_id(source, status),
        stamp=time(source.clock.ns(status.began)),
    )
    code = OVER.get(status.state, EXECUTING)
    newest = new("action_msgs/msg/GoalStatus", goal_info=info, status=code)
    return new("action_msgs/msg/GoalStatusArray", status_list=[newest])


def feedback_stamp(snapshot: Snapshot) -> float | None:
    """The stamp of feedback; None while no goal is driven to."""
    status = _to_goal(snapshot)
    if status is None or not status.active or snapshot.pose is None:
        return None
    return math.floor(snapshot.stamp / FEEDBACK_S) * FEEDBACK_S


def feedback(source: TopicSource, snapshot: Snapshot) -> Message:
    """nav2_msgs/NavigateToPose_FeedbackMessage: how far it is to the next goal."""
    status = snapshot.added["navigation"]
    assert snapshot.pose is not None  # as feedback_stamp has it
    place = new(
        "geometry_msgs/msg/PoseStamped",
        header=header(source, snapshot.stamp, source.settings.global_frame_id),
        pose=pose(snapshot.pose),
    )
    progress = new(
        "nav2_msgs/action/NavigateToPose_Feedback",
        current_pose=place,
        navigation_time=_duration(snapshot.stamp - status.began),
        estimated_time_remaining=_duration(status.remaining_s),
        number_of_recoveries=0,
        distance_remaining=float(status.remaining_m),
    )
    return new(FEEDBACK, goal_id=_goal_id(source, status), feedback=progress)


def _to_goal(snapshot: Snapshot) -> NavigationStatus | None:
    """Return how far a journey to goals is; None of one along a curve or tape."""
    status: NavigationStatus | None = snapshot.added.get("navigation")
    return None if status is None or not status.goals else status


def _goal_id(source: TopicSource, status: NavigationStatus) -> Message:
    number = uuid.uuid5(GOALS, str(source.clock.ns(status.began)))
    return new("unique_identifier_msgs/msg/UUID", uuid=np.frombuffer(number.bytes, np.uint8).copy())


def _duration(seconds: float) -> Message:
    sec, nanosec = divmod(round(seconds * 1e9), SECOND_NS)
    return new("builtin_interfaces/msg/Duration", sec=sec, nanosec=nanosec)
