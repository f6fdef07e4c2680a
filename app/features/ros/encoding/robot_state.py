"""robot_description, battery_state, diagnostics; and what it is told: initialpose, command."""

from __future__ import annotations

import json
import math

import numpy as np

from app.engine.pose_commands import covariance_of
from app.engine.snapshot import Snapshot
from app.engine.values import values
from app.features.navigation.messages import GoalMessage, NavigateCommand
from app.features.ros.encoding.frames import header, pose, pose_with_covariance
from app.features.ros.encoding.motion import each_second
from app.features.ros.message_types import Message, new
from app.features.ros.source import TopicSource
from app.messages.commands import PingCommand, SetPoseCommand
from robot.geometry import Pose2
from robot.localization.estimate import Integrity, State

UNMEASURED = ("temperature", "current", "charge", "capacity", "design_capacity", "percentage")
"""Fields of sensor_msgs/BatteryState that are not measured: they are NaN."""
OK, WARN, ERROR = 0, 1, 2
"""Levels of diagnostic_msgs/DiagnosticStatus."""
LEVELS = {
    State.CERTAIN: OK,
    State.GIVEN: OK,
    State.APPROXIMATE: OK,
    State.AMBIGUOUS: WARN,
    State.SEARCHING: WARN,
    State.LOST: ERROR,
}
"""Level of each state without alerts; with an alert, it is at least WARN."""


def robot_description(source: TopicSource, snapshot: Snapshot) -> Message:
    """The URDF."""
    return new("std_msgs/msg/String", data=source.robot(snapshot).spec.urdf)


def battery_stamp(snapshot: Snapshot) -> float | None:
    """A stamp that changes once a second; None if the voltage is not measured."""
    return None if snapshot.battery_v is None else each_second(snapshot)


def battery_state(source: TopicSource, snapshot: Snapshot) -> Message:
    """The supply voltage; nothing else is measured."""
    unknown = dict.fromkeys(UNMEASURED, math.nan)
    assert snapshot.battery_v is not None  # otherwise the stamp is None
    return new(
        "sensor_msgs/msg/BatteryState",
        header=header(source, snapshot.stamp, source.settings.base_frame_id),
        voltage=float(snapshot.battery_v),
        **unknown,
        power_supply_status=0,
        power_supply_health=0,
        power_supply_technology=0,
        present=True,
        cell_voltage=np.empty(0, dtype=np.float32),
        cell_temperature=np.empty(0, dtype=np.float32),
        location="",
        serial_number="",
    )


def commands_stamp(snapshot: Snapshot) -> float | None:
    """The tick's stamp if the tick has commands for the robot or the filter, else None."""
    return snapshot.stamp if _recorded_commands(snapshot) else None


def commands_as_json(source: TopicSource, snapshot: Snapshot) -> Message:
    """The tick's commands as a JSON list, oldest first."""
    return new("std_msgs/msg/String", data=json.dumps(_recorded_commands(snapshot)))


def _recorded_commands(snapshot: Snapshot) -> list[dict[str, object]]:
    return [
        command.model_dump(mode="json", exclude_none=True)
        for command in snapshot.commands
        if not isinstance(command, PingCommand)
    ]


def initial_pose_stamp(snapshot: Snapshot) -> float | None:
    """The tick's stamp if a pose was set in it, else None."""
    return snapshot.stamp if _initial_pose(snapshot) else None


def initial_pose(source: TopicSource, snapshot: Snapshot) -> Message:
    """The last pose that was set, as RViz would have sent it."""
    command = _initial_pose(snapshot)
    assert command is not None  # otherwise the stamp is None
    return new(
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        header=header(source, snapshot.stamp, source.settings.global_frame_id),
        pose=pose_with_covariance(
            Pose2(command.x, command.y, command.theta),
            covariance_of(command, snapshot.filter.parameters.filter),
        ),
    )


def _initial_pose(snapshot: Snapshot) -> SetPoseCommand | None:
    poses = [command for command in snapshot.commands if isinstance(command, SetPoseCommand)]
    return poses[-1] if poses else None


def goal_pose_stamp(snapshot: Snapshot) -> float | None:
    """The tick's stamp if the robot was sent to a single goal in it, else None."""
    return snapshot.stamp if _goal(snapshot) else None


def goal_pose(source: TopicSource, snapshot: Snapshot) -> Message:
    """The last goal that was given, as RViz would have sent it; without a heading, as it faces."""
    goal = _goal(snapshot)
    assert goal is not None  # otherwise the stamp is None
    heading = goal.theta
    if heading is None:
        heading = (snapshot.pose or snapshot.odometry).theta
    return new(
        "geometry_msgs/msg/PoseStamped",
        header=header(source, snapshot.stamp, source.settings.global_frame_id),
        pose=pose(Pose2(goal.x, goal.y, heading)),
    )


def _goal(snapshot: Snapshot) -> GoalMessage | None:
    goals = [
        command.poses[0]
        for command in snapshot.commands
        if isinstance(command, NavigateCommand) and command.poses and len(command.poses) == 1
    ]
    return goals[-1] if goals else None


def diagnostics(source: TopicSource, snapshot: Snapshot) -> Message:
    """The status of the program's loop, of the robot, and of the estimate's integrity."""
    figures = {value.name: value.text(snapshot) for value in values()}
    problems, faults = " ".join(snapshot.problems.present), " ".join(snapshot.reading.faults)
    status = [
        _health(source, "brickpose: program", problems, figures),
        _health(source, "brickpose: robot", faults, {}),
        _localization(source, snapshot.integrity),
    ]
    position = header(source, snapshot.stamp, "")
    return new("diagnostic_msgs/msg/DiagnosticArray", header=position, status=status)


def _localization(source: TopicSource, claimed: Integrity) -> Message:
    doubts = [alert.text for alert in claimed.alerts]
    level = max(LEVELS[claimed.state], WARN if doubts else OK)
    figures = {
        "state": claimed.state.value,
        "radius_m": f"{claimed.radius:.5g}",
        "heading_bound_rad": f"{claimed.heading_bound:.5g}",
        "causes": "; ".join(alert.cause.value for alert in claimed.alerts),
        "alerts": "; ".join(doubts),
    }
    message = ": ".join([claimed.state.value, *filter(None, [figures["alerts"]])])
    return _status(source, "brickpose: localization", level, message, figures)


def _health(source: TopicSource, name: str, wrong: str, figures: dict[str, str]) -> Message:
    return _status(source, name, WARN if wrong else OK, wrong or "All is well.", figures)


def _status(
    source: TopicSource, name: str, level: int, message: str, figures: dict[str, str]
) -> Message:
    return new(
        "diagnostic_msgs/msg/DiagnosticStatus",
        level=level,
        name=name,
        message=message,
        hardware_id=source.robot_name,
        values=[new("diagnostic_msgs/msg/KeyValue", key=k, value=v) for k, v in figures.items()],
    )
