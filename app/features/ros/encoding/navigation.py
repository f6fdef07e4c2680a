"""The way to a goal as nav_msgs/Path."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from app.engine.snapshot import Snapshot
from app.features.ros.encoding.frames import header, pose
from app.features.ros.message_types import Message, new
from app.features.ros.source import TopicSource
from robot.geometry import Pose2


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
