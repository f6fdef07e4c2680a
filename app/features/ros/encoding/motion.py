"""The robot's motion and the filter's belief as messages: odom, tf, joints, amcl_pose, clouds."""

from __future__ import annotations

import struct

import numpy as np

from app.engine.snapshot import Snapshot
from app.features.ros.encoding.frames import (
    SECOND_NS,
    header,
    in_space,
    link_transform,
    pose,
    pose_with_covariance,
    transform,
    vector,
)
from app.features.ros.message_types import Message, new
from app.features.ros.source import TopicSource
from robot.geometry import Array, Pose2, Twist2
from robot.scan import evenly

POSE_VARIANCE = (1e-3, 1e-3, 1e-2)
"""Variances of the pose in odom [m^2, m^2, rad^2]. They are constant, as in diff_drive_controller,
for users who need some; the true error of odometry grows with the distance."""

TWIST_VARIANCE = (1e-4, 1e-6, 1e-3)
"""Variances of the twist in odom [m^2/s^2, m^2/s^2, rad^2/s^2]."""

POSE_COVARIANCE = np.diag(POSE_VARIANCE)
TWIST_COVARIANCE = in_space(np.diag(TWIST_VARIANCE))
LITTLE_ENDIAN = b"\x00\x01\x00\x00"
"""Encapsulation header of an XCDR1 message in little endian."""


def odometry(source: TopicSource, snapshot: Snapshot) -> Message:
    """Dead reckoning, and the velocity from the measured wheel velocities.

    Where pictures correct it, its covariance is the measured one, which grows with the way.
    """
    settings = source.settings
    corrected = getattr(snapshot.added.get("picture_odometry"), "odom_covariance", None)
    covariance = POSE_COVARIANCE if corrected is None else corrected
    twist = source.robot(snapshot).drive.twist(snapshot.reading.velocities)
    return new(
        "nav_msgs/msg/Odometry",
        header=header(source, snapshot.stamp, settings.odom_frame_id),
        child_frame_id=settings.base_frame_id,
        pose=pose_with_covariance(snapshot.odom_from_robot, covariance),
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
    """Where odometry began in the published map: the one that is drawn, else the field's."""
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


def estimate_stamp(snapshot: Snapshot) -> float | None:
    """Stamp of the filter's newest estimate; None before the first one."""
    return snapshot.estimate.stamp if snapshot.estimate else None


def amcl_pose(source: TopicSource, snapshot: Snapshot) -> Message:
    """The estimate, with its own stamp."""
    estimate = snapshot.estimate
    assert estimate is not None  # otherwise the stamp is None
    return new(
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        header=header(source, estimate.stamp, source.settings.global_frame_id),
        pose=pose_with_covariance(estimate.pose, estimate.covariance),
    )


def particle_cloud(source: TopicSource, snapshot: Snapshot) -> bytes:
    """nav2_msgs/ParticleCloud: a header, a count, and eight numbers per particle.

    The bytes are written directly: making an object of each pose takes fifty times as long.
    """
    poses, weights = _chosen(source, snapshot)
    return _counted(source, snapshot, np.column_stack([_poses(poses), weights]))


def pose_array(source: TopicSource, snapshot: Snapshot) -> bytes:
    """geometry_msgs/PoseArray: the cloud without weights, for older versions of RViz."""
    poses, _ = _chosen(source, snapshot)
    return _counted(source, snapshot, _poses(poses))


def _chosen(source: TopicSource, snapshot: Snapshot) -> tuple[Array, Array]:
    """At most ``most_particles`` poses (n, 3), with weights (n,) that sum to one."""
    cloud = snapshot.filter.cloud
    chosen = evenly(len(cloud.weights), source.settings.most_particles)
    weights = cloud.weights[chosen]
    return cloud.poses[chosen], weights / weights.sum()


def _poses(poses: Array) -> Array:
    """Convert poses (n, 3) to x, y, z and a quaternion (n, 7)."""
    x, y, theta = poses.T
    nought = np.zeros(len(poses))
    half = theta / 2
    return np.column_stack([x, y, nought, nought, nought, np.sin(half), np.cos(half)])


def _counted(source: TopicSource, snapshot: Snapshot, rows: Array) -> bytes:
    """Encode a header and a sequence of rows (n, k) of doubles as CDR."""
    frame = source.settings.global_frame_id.encode() + b"\0"
    seconds, nanoseconds = divmod(source.clock.ns(snapshot.stamp), SECOND_NS)
    body = struct.pack(f"<iII{len(frame)}s", seconds, nanoseconds, len(frame), frame)
    body += bytes(-len(body) % 4) + struct.pack("<I", len(rows))
    body += bytes(-len(body) % 8)
    return LITTLE_ENDIAN + body + rows.astype("<f8").tobytes()


def true_pose(source: TopicSource, snapshot: Snapshot) -> Message:
    """The true pose, from the simulator."""
    assert snapshot.truth is not None  # otherwise the stamp is None
    frame = source.settings.global_frame_id
    return new(
        "geometry_msgs/msg/PoseStamped",
        header=header(source, snapshot.stamp, frame),
        pose=pose(snapshot.truth),
    )


def truth_stamp(snapshot: Snapshot) -> float | None:
    """The tick's stamp if the truth is known, else None."""
    return None if snapshot.truth is None else snapshot.stamp
