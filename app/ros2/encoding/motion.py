"""odom, tf, joint_states, cmd_vel: the robot's motion."""

from __future__ import annotations

import numpy as np

from app.engine.snapshot import Snapshot
from app.ros2.encoding.frames import (
    header,
    in_space,
    link_transform,
    pose_with_covariance,
    transform,
    vector,
)
from app.ros2.message_types import Message, new
from app.ros2.source import TopicSource
from robot.geometry import Array, Pose2, Twist2

POSE_VARIANCE = (1e-3, 1e-3, 1e-2)
"""Variances of the pose in odom [m^2, m^2, rad^2]. They are constant, as in diff_drive_controller,
for users who need some; the true error of odometry grows with the distance."""

TWIST_VARIANCE = (1e-4, 1e-6, 1e-3)
"""Variances of the twist in odom [m^2/s^2, m^2/s^2, rad^2/s^2]."""

POSE_COVARIANCE = np.diag(POSE_VARIANCE)
TWIST_COVARIANCE = in_space(np.diag(TWIST_VARIANCE))


def odometry(source: TopicSource, snapshot: Snapshot) -> Message:
    """Dead reckoning, and the velocity from the measured wheel velocities."""
    settings = source.settings
    twist = source.robot(snapshot).drive.twist(snapshot.reading.velocities)
    return new(
        "nav_msgs/msg/Odometry",
        header=header(source, snapshot.stamp, settings.odom_frame_id),
        child_frame_id=settings.base_frame_id,
        pose=pose_with_covariance(snapshot.odom_from_robot, POSE_COVARIANCE),
        twist=new(
            "geometry_msgs/msg/TwistWithCovariance",
            twist=_twist(twist),
            covariance=TWIST_COVARIANCE,
        ),
    )


def transforms(source: TopicSource, snapshot: Snapshot) -> Message:
    """odom -> robot, the wheels, and with ``tf_broadcast`` map -> odom once there is a pose."""
    stamp, settings = snapshot.stamp, source.settings
    odom, base = settings.odom_frame_id, settings.base_frame_id
    result = [transform(source, stamp, odom, base, snapshot.odom_from_robot)]
    map_from_odom = _map_from_odom(snapshot)
    if map_from_odom is not None and settings.tf_broadcast:
        result.append(transform(source, stamp, settings.global_frame_id, odom, map_from_odom))
    angles: Array = snapshot.reading.positions
    for wheel, angle in zip(source.robot(snapshot).links.wheels, angles.tolist(), strict=True):
        result.append(link_transform(source, stamp, wheel, wheel.turned(angle)))
    return new("tf2_msgs/msg/TFMessage", transforms=result)


def _map_from_odom(snapshot: Snapshot) -> Pose2 | None:
    """Where odometry began in the map that is told: the one that is drawn, else the field's."""
    if snapshot.drawn is not None:
        return snapshot.drawn.map_from_odom
    return None if snapshot.pose is None else snapshot.pose @ snapshot.odom_from_robot.inverse()


def static_transforms(source: TopicSource, snapshot: Snapshot) -> Message:
    """The transforms of the robot's fixed links."""
    stamp, links = snapshot.stamp, source.robot(snapshot).links
    result = [link_transform(source, stamp, item, item.turn) for item in links.fixed]
    return new("tf2_msgs/msg/TFMessage", transforms=result)


def joint_states(source: TopicSource, snapshot: Snapshot) -> Message:
    """The wheels' positions and velocities, as the robot read them."""
    reading = snapshot.reading
    return new(
        "sensor_msgs/msg/JointState",
        header=header(source, reading.stamp, ""),
        name=[joint.name for joint in source.robot(snapshot).spec.joints],
        position=reading.positions,
        velocity=reading.velocities,
        effort=np.empty(0),
    )


def applied_velocity(source: TopicSource, snapshot: Snapshot) -> Message:
    """The velocity that was commanded in this tick, after limits."""
    return new(
        "geometry_msgs/msg/TwistStamped",
        header=header(source, snapshot.stamp, source.settings.base_frame_id),
        twist=_twist(snapshot.twist),
    )


def _twist(twist: Twist2) -> Message:
    linear, angular = vector(twist.v), vector(0.0, 0.0, twist.omega)
    return new("geometry_msgs/msg/Twist", linear=linear, angular=angular)


def tick_stamp(snapshot: Snapshot) -> float:
    """The stamp of content that is new in each tick."""
    return snapshot.stamp


def each_second(snapshot: Snapshot) -> float:
    """The stamp of content that is new once a second."""
    return float(np.floor(snapshot.stamp))


def calibration_stamp(snapshot: Snapshot) -> float:
    """The stamp of content that only a calibration changes."""
    return snapshot.calibrated  # UNCHANGING before the first calibration
