"""Write bags of laser robots, of any kind, for tests and benchmarks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Ros2Writer

from app.features.lab.localize.reading.bag import message_types
from robot.geometry import Pose2

KINDS = ("ros1", "sqlite3", "mcap")
SCAN, ODOMETRY, TRANSFORMS = (
    "sensor_msgs/msg/LaserScan",
    "nav_msgs/msg/Odometry",
    "tf2_msgs/msg/TFMessage",
)


class LaserBag:
    """A bag to write; a context manager."""

    def __init__(self, path: Path, kind: str) -> None:
        """Begin a bag of a kind: a file for ros1, else a folder."""
        self.path = path
        self._ros1 = kind == "ros1"
        self.store = message_types(ros1=self._ros1)
        self._writer: Any = (
            Ros1Writer(path)
            if self._ros1
            else Ros2Writer(path, version=9, storage_plugin=StoragePlugin[kind.upper()])
        )
        self._connections: dict[str, Any] = {}

    def __enter__(self) -> LaserBag:
        self._writer.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.close()

    def type(self, name: str) -> Any:
        """Return a message type by name."""
        return self.store.types[name]

    def header(self, stamp: float, frame: str) -> Any:
        """Make a header with a stamp [s] and a frame."""
        seconds = math.floor(stamp)
        time = self.type("builtin_interfaces/msg/Time")(seconds, round((stamp - seconds) * 1e9))
        header = self.type("std_msgs/msg/Header")
        return header(0, time, frame) if self._ros1 else header(time, frame)

    def write(self, topic: str, kind: str, message: Any, logged: float) -> None:
        """Write a message that was recorded at a time [s]."""
        if topic not in self._connections:
            added = self._writer.add_connection(topic, kind, typestore=self.store)
            self._connections[topic] = added
        encode = self.store.serialize_ros1 if self._ros1 else self.store.serialize_cdr
        self._writer.write(self._connections[topic], round(logged * 1e9), encode(message, kind))

    def scan(
        self,
        stamp: float,
        ranges: ArrayLike,
        *,
        first: float,
        step: float,
        reach: tuple[float, float] = (0.05, 30.0),
        frame: str = "laser",
        topic: str = "/scan",
        logged: float | None = None,
    ) -> None:
        """Write a scan; its rays begin at an angle [rad] and advance by a step [rad]."""
        values = np.asarray(ranges, dtype=np.float32)
        low, high = reach
        last = first + step * (len(values) - 1)
        nothing = np.zeros(0, dtype=np.float32)
        message = self.type(SCAN)(
            self.header(stamp, frame), first, last, step, 0.0, 0.0, low, high, values, nothing
        )
        self.write(topic, SCAN, message, stamp if logged is None else logged)

    def odometry(
        self,
        stamp: float,
        pose: Pose2,
        *,
        base: str = "base_link",
        topic: str = "/odom",
        logged: float | None = None,
    ) -> None:
        """Write the robot's pose in the odom frame."""
        place = self.type("geometry_msgs/msg/Pose")(self._point(pose.x, pose.y), self._turn(pose))
        zero = self.type("geometry_msgs/msg/Vector3")(0.0, 0.0, 0.0)
        message = self.type(ODOMETRY)(
            self.header(stamp, "odom"),
            base,
            self.type("geometry_msgs/msg/PoseWithCovariance")(place, np.zeros(36)),
            self.type("geometry_msgs/msg/TwistWithCovariance")(
                self.type("geometry_msgs/msg/Twist")(zero, zero), np.zeros(36)
            ),
        )
        self.write(topic, ODOMETRY, message, stamp if logged is None else logged)

    def transform(
        self,
        stamp: float,
        parent: str,
        child: str,
        pose: Pose2,
        *,
        rolled: bool = False,
        topic: str = "/tf",
    ) -> None:
        """Write the transform between two frames; ``rolled`` adds half a turn about x."""
        vector = self.type("geometry_msgs/msg/Vector3")(float(pose.x), float(pose.y), 0.2)
        turn = self._turn(pose)
        if rolled:  # (0, 0, s, c) times the half turn (1, 0, 0, 0)
            turn = self.type("geometry_msgs/msg/Quaternion")(turn.w, turn.z, 0.0, 0.0)
        moved = self.type("geometry_msgs/msg/Transform")(vector, turn)
        stamped = self.type("geometry_msgs/msg/TransformStamped")
        message = self.type(TRANSFORMS)([stamped(self.header(stamp, parent), child, moved)])
        self.write(topic, TRANSFORMS, message, stamp)

    def _point(self, x: float, y: float) -> Any:
        return self.type("geometry_msgs/msg/Point")(float(x), float(y), 0.0)

    def _turn(self, pose: Pose2) -> Any:
        half = pose.theta / 2
        return self.type("geometry_msgs/msg/Quaternion")(0.0, 0.0, math.sin(half), math.cos(half))
