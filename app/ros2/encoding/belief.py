"""amcl_pose and the clouds: the filter's belief; and the truth, which only a simulator knows."""

from __future__ import annotations

import struct

import numpy as np

from app.engine.snapshot import Snapshot
from app.ros2.encoding.frames import SECOND_NS, header, pose, pose_with_covariance
from app.ros2.message_types import Message, new
from app.ros2.source import TopicSource
from robot.geometry import Array
from robot.scan import evenly

LITTLE_ENDIAN = b"\x00\x01\x00\x00"
"""Encapsulation header of an XCDR1 message in little endian."""


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
    cloud = snapshot.cloud
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
