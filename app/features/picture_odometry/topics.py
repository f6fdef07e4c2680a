"""The picture's odometer as topics: its motion, and the floor from above."""

from __future__ import annotations

import numpy as np

from app.engine.snapshot import Snapshot
from app.features.picture_odometry.routes import floor_jpeg
from app.features.picture_odometry.values import motion_state
from app.features.ros.encoding.frames import header, in_space, pose_with_covariance, vector
from app.features.ros.message_types import Message, new
from app.features.ros.source import TopicSource
from app.features.ros.topics import Topic


def motion_stamp(snapshot: Snapshot) -> float | None:
    """When the newest motion ended; None before the first, or if it is not measured."""
    state = motion_state(snapshot)
    return None if state is None else state.motion.end


def picture_odometry(source: TopicSource, snapshot: Snapshot) -> Message:
    """Dead reckoning by pictures alone, and the velocity between the last two.

    The twist's covariance is the motion's; variances of 100 and more stand for what is not seen.
    """
    state, settings = motion_state(snapshot), source.settings
    assert state is not None  # otherwise the stamp is None
    motion = state.motion
    seconds = motion.end - motion.begin
    moved, covariance = motion.motion, motion.covariance / seconds**2
    twist = new(
        "geometry_msgs/msg/Twist",
        linear=vector(moved.x / seconds, moved.y / seconds),
        angular=vector(0.0, 0.0, moved.theta / seconds),
    )
    return new(
        "nav_msgs/msg/Odometry",
        header=header(source, motion.end, settings.odom_frame_id),
        child_frame_id=settings.base_frame_id,
        pose=pose_with_covariance(state.odom_from_robot, np.diag([1e-3, 1e-3, 1e-3])),
        twist=new(
            "geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=in_space(covariance)
        ),
    )


def floor_stamp(snapshot: Snapshot) -> float | None:
    """Stamp of the picture of this tick; None without one, or if motion is not measured."""
    frame = snapshot.reading.frame
    return None if frame is None or motion_state(snapshot) is None else frame.stamp


def floor_image(source: TopicSource, snapshot: Snapshot) -> Message:
    """The floor before the robot from above, as JPEG."""
    frame = snapshot.reading.frame
    assert frame is not None  # otherwise the stamp is None
    data = floor_jpeg(source.robot(snapshot).spec.floor_view, frame)
    return new(
        "sensor_msgs/msg/CompressedImage",
        header=header(source, frame.stamp, source.settings.base_frame_id),
        format="mono8; jpeg compressed mono8",
        data=np.frombuffer(data, dtype=np.uint8),
    )


TOPICS = (
    Topic("odom_picture", "nav_msgs/msg/Odometry", motion_stamp, picture_odometry),
    Topic(
        "floor/image/compressed",
        "sensor_msgs/msg/CompressedImage",
        floor_stamp,
        floor_image,
        "picture_rate",
    ),
)
"""What rosbridge, Foxglove, DDS and recordings have besides, while motion is measured."""
