"""``ActionGoal``: one client's goal of an action of nav2, which drives the robot there."""

from __future__ import annotations

import threading
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from app.engine.driver import Driver
from app.engine.snapshot import Snapshot
from app.features.navigation.messages import CancelCommand, GoalMessage, NavigateCommand
from app.features.ros.encoding.frames import SECOND_NS, header, pose
from app.features.ros.encoding.navigation import ABORTED, CANCELED, FEEDBACK_S, SUCCEEDED
from app.features.ros.inbox import Inbox
from app.features.ros.incoming import goal_of
from app.features.ros.message_types import Message, MessageError, new
from app.features.ros.rosbridge.encoding import json_values
from app.features.ros.rosbridge.reading import message_of, shown
from robot.geometry import Pose2
from robot.navigation.navigation_status import NavigationStatus
from robot.worker_thread import WorkerThread

UNKNOWN_ERROR = 9000
"""nav2's error code of its navigators for what it has no other one."""
BEGINS_S = 3.0
"""A goal that no tick shows within this time [s] was lost."""

Values = dict[str, Any]
POSE = "geometry_msgs/msg/PoseStamped"


@dataclass(frozen=True)
class Action:
    """An action that the robot offers."""

    name: str
    type: str
    field: str
    """Of the goal: its pose, or its list of poses."""
    many: bool
    result: Callable[[int, str], Values]
    """Fields of the result, by error code and its words."""
    progress: Callable[[NavigationStatus], Values]
    """Fields of the feedback that other actions have not."""


def _errors(code: int, words: str) -> Values:
    return {"error_code": code, "error_msg": words}


ACTIONS = (
    Action(
        "navigate_to_pose", "nav2_msgs/action/NavigateToPose", "pose", False, _errors,
        lambda status: {},
    ),
    Action(
        "navigate_through_poses", "nav2_msgs/action/NavigateThroughPoses", "poses", True, _errors,
        lambda status: {"number_of_poses_remaining": len(status.goals) - status.number},
    ),
    Action(
        "follow_waypoints", "nav2_msgs/action/FollowWaypoints", "poses", True,
        lambda code, words: {"missed_waypoints": [], **_errors(code, words)},
        lambda status: {"current_waypoint": status.number},
    ),
)  # fmt: skip


class ActionGoal:
    """One goal of a client, from its command to its result; a thread watches it."""

    def __init__(
        self,
        action: Action,
        inbox: Inbox,
        driver: Driver,
        feedback: Callable[[Values], None],
        ended: Callable[[int, Values], None],
    ) -> None:
        """Prepare; ``feedback`` and ``ended`` are called in the thread."""
        self._action = action
        self._inbox = inbox
        self._driver = driver
        self._feedback = feedback
        self._ended = ended
        self._name = uuid.uuid4().hex
        self._canceled = False
        self._thread = WorkerThread(
            "action goal", self._watch, owner="the goal of an action", patience=3.0
        )

    def begin(self, arguments: Values) -> None:
        """Send the robot there.

        Raises:
            MessageError, CommandError: a pose is invalid, or the robot may not go there.
        """
        given = arguments.get(self._action.field)
        poses = [message_of(each, POSE) for each in _poses(self._action, given)]
        places = [goal_of(self._inbox.source, self._action.name, pose) for pose in poses]
        goals = [GoalMessage(x=place.x, y=place.y, theta=place.theta) for place in places]
        command = NavigateCommand(type="navigate", id=self._name, poses=goals)
        self._inbox.carry_out(command, self._driver)
        self._thread.start()

    def cancel(self) -> None:
        """End the journey; the result tells so."""
        self._canceled = True
        self._inbox.carry_out(CancelCommand(type="cancel"), self._driver)

    @property
    def watched(self) -> bool:
        """Whether its result is yet to come."""
        return self._thread.alive

    def close(self) -> None:
        """Watch it no more."""
        self._thread.stop()

    def _watch(self, stopping: threading.Event) -> None:
        began, seen = time.monotonic(), False
        while not stopping.wait(FEEDBACK_S):
            snapshot = self._inbox.newest
            status: NavigationStatus | None = snapshot.added.get("navigation") if snapshot else None
            mine = status is not None and status.name == self._name
            if status is None or snapshot is None or not mine:
                if not seen and time.monotonic() - began < BEGINS_S:
                    continue
                self._end(ABORTED, "another goal took its place" if seen else "the goal was lost")
                return
            seen = True
            if not status.active:
                self._end_with(status)
                return
            self._feedback(self._values(snapshot, status, time.monotonic() - began))

    def _end_with(self, status: NavigationStatus) -> None:
        if status.state == "arrived":
            self._ended(SUCCEEDED, self._action.result(0, ""))
        else:
            self._end(CANCELED if self._canceled else ABORTED, status.reason)

    def _end(self, code: int, words: str) -> None:
        error = 0 if code == CANCELED else UNKNOWN_ERROR
        self._ended(code, self._action.result(error, words))

    def _values(self, snapshot: Snapshot, status: NavigationStatus, passed: float) -> Values:
        values = {
            "navigation_time": _duration(passed),
            "estimated_time_remaining": _duration(status.remaining_s),
            "number_of_recoveries": 0,
            "distance_remaining": status.remaining_m,
            **self._action.progress(status),
        }
        if snapshot.pose is not None:
            values["current_pose"] = json_values(
                _in_map(self._inbox, snapshot.pose, snapshot.stamp)
            )
        return values


def _poses(action: Action, given: Any) -> list[Any]:
    """Return the poses in a goal; what is none is refused when it is read."""
    if not action.many:
        return [given]
    if not isinstance(given, list) or not given:
        raise MessageError(f"{action.name}: {action.field} is {shown(given)}; valid is a list")
    return given


def _in_map(inbox: Inbox, place: Pose2, stamp: float) -> Message:
    frame = inbox.source.settings.global_frame_id
    return new(POSE, header=header(inbox.source, stamp, frame), pose=pose(place))


def _duration(seconds: float) -> Values:
    sec, nanosec = divmod(round(seconds * 1e9), SECOND_NS)
    return {"sec": sec, "nanosec": nanosec}
