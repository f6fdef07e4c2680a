"""Where the robot's links are on each other: what robot_state_publisher would tell."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from app.ros2.settings import Ros2Settings
from robot.description.spec import RobotSpec
from robot.description.urdf import parse_xml, read_model

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""x, y, z, w"""


@dataclass(frozen=True)
class Link:
    """One link on its parent."""

    parent: str
    child: str
    place: Vector
    """[m] in the parent's frame."""
    turn: Quaternion = (0.0, 0.0, 0.0, 1.0)
    """Of a wheel: at position zero."""
    axis: Vector = (0.0, 0.0, 0.0)
    """Unit vector that a wheel turns about, in its own frame."""

    def turned(self, angle: float) -> Quaternion:
        """The turn of a wheel at a position [rad]: the product of two quaternions."""
        x, y, z, w = self.turn
        sine, cosine = math.sin(angle / 2), math.cos(angle / 2)
        a, b, c = (sine * one for one in self.axis)
        return (
            w * a + x * cosine + y * c - z * b,
            w * b + y * cosine + z * a - x * c,
            w * c + z * cosine + x * b - y * a,
            w * cosine - x * a - y * b - z * c,
        )


@dataclass(frozen=True)
class Links:
    """All links of a robot."""

    fixed: tuple[Link, ...]
    wheels: tuple[Link, ...]
    """In the order of the joints."""
    camera: str
    """The frame that the camera's pictures are in."""

    @classmethod
    def of(cls, spec: RobotSpec, settings: Ros2Settings, scan_x: float) -> Links:
        """From the robot's description; scans start so far in front of the robot's origin [m]."""
        joints = {joint.name: joint for joint in read_model(spec.urdf).robot.joints}
        root, base = parse_xml(spec.urdf), settings.base_frame_id
        fixed = [_link(one) for one in joints.values() if one.type == "fixed"]
        frame = root.find("ros2_control/sensor/param[@name='frame']")
        assert frame is not None  # a robot without a camera has no RobotSpec
        return cls(
            (*fixed, Link(base, settings.scan_frame_id, (scan_x, 0.0, 0.0))),
            tuple(_link(joints[joint.name]) for joint in spec.joints),
            (frame.text or "").strip(),
        )


def _link(joint: Any) -> Link:
    """Of a joint as yourdfpy has it."""
    origin = np.eye(4) if joint.origin is None else joint.origin
    x, y, z = origin[:3, 3].astype(float).tolist()
    qx, qy, qz, qw = Rotation.from_matrix(origin[:3, :3]).as_quat().tolist()
    ax, ay, az = (0.0, 0.0, 0.0) if joint.axis is None else map(float, joint.axis)
    return Link(joint.parent, joint.child, (x, y, z), (qx, qy, qz, qw), (ax, ay, az))
