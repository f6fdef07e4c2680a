"""Headers, poses and transforms: the parts of most messages."""

from __future__ import annotations

import math

import numpy as np

from app.features.ros.links import PlacedLink, Quaternion
from app.features.ros.message_types import Message, new
from app.features.ros.source import TopicSource
from robot.geometry import Array, Pose2

SECOND_NS = 1_000_000_000

IN_SPACE = np.array([0, 1, 5, 6, 7, 11, 30, 31, 35])
"""Indices of the covariance of x, y and heading in the 36 numbers of a covariance in space."""


def time(time_ns: int) -> Message:
    """Nanoseconds since 1970 as builtin_interfaces/Time."""
    seconds, nanoseconds = divmod(time_ns, SECOND_NS)
    return new("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)


def header(source: TopicSource, stamp: float, frame_id: str) -> Message:
    """A header with a stamp of the robot's clock [s]."""
    return new("std_msgs/msg/Header", stamp=time(source.clock.ns(stamp)), frame_id=frame_id)


def vector(x: float, y: float = 0.0, z: float = 0.0) -> Message:
    """geometry_msgs/Vector3"""
    return new("geometry_msgs/msg/Vector3", x=float(x), y=float(y), z=float(z))


def turned(theta: float) -> Message:
    """A heading [rad] as a quaternion about z."""
    z, w = math.sin(theta / 2), math.cos(theta / 2)
    return new("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=z, w=w)


def heading_of(turn: Message) -> float:
    """The heading [rad] of a quaternion: the direction of the rotated x axis, seen from above."""
    x, y, z, w = turn.x, turn.y, turn.z, turn.w
    return math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def pose(pose2: Pose2) -> Message:
    """geometry_msgs/Pose on the floor."""
    position = new("geometry_msgs/msg/Point", x=float(pose2.x), y=float(pose2.y), z=0.0)
    return new("geometry_msgs/msg/Pose", position=position, orientation=turned(pose2.theta))


def pose_with_covariance(pose2: Pose2, covariance: Array) -> Message:
    """geometry_msgs/PoseWithCovariance of a pose and a covariance (3, 3) [m², m rad, rad²]."""
    return new(
        "geometry_msgs/msg/PoseWithCovariance", pose=pose(pose2), covariance=in_space(covariance)
    )


def in_space(covariance: Array) -> Array:
    """Expand a covariance (3, 3) on the floor to 36 numbers, row by row.

    The order is x, y, z, rotation about x, about y, about z.
    """
    whole = np.zeros(36)
    whole[IN_SPACE] = covariance.ravel()
    return whole


def transform(source: TopicSource, stamp: float, parent: str, child: str, pose2: Pose2) -> Message:
    """geometry_msgs/TransformStamped on the floor."""
    return stamped_transform(
        source, stamp, parent, child, vector(pose2.x, pose2.y), turned(pose2.theta)
    )


def link_transform(
    source: TopicSource, stamp: float, link: PlacedLink, turn: Quaternion
) -> Message:
    """geometry_msgs/TransformStamped of a link that has this rotation relative to its parent."""
    x, y, z, w = turn
    orientation = new("geometry_msgs/msg/Quaternion", x=x, y=y, z=z, w=w)
    place = vector(*link.place)
    return stamped_transform(source, stamp, link.parent, link.child, place, orientation)


def stamped_transform(
    source: TopicSource, stamp: float, parent: str, child: str, place: Message, turn: Message
) -> Message:
    """geometry_msgs/TransformStamped from its parts."""
    return new(
        "geometry_msgs/msg/TransformStamped",
        header=header(source, stamp, parent),
        child_frame_id=child,
        transform=new("geometry_msgs/msg/Transform", translation=place, rotation=turn),
    )
