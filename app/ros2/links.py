"""Where the robot's links are on each other: what robot_state_publisher would tell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from app.ros2.settings import Ros2Settings
from robot.description.spec import RobotSpec
from robot.description.urdf import parse_xml, read_model
from robot.geometry import Array


@dataclass(frozen=True)
class Link:
    """One link on its parent."""

    parent: str
    child: str
    parent_from_child: Array
    """(4, 4); of a wheel, at position zero."""
    axis: Array
    """(3,) unit vector that a wheel turns about, in its own frame."""


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
        scan = np.eye(4)
        scan[0, 3] = scan_x
        fixed = [_link(one) for one in joints.values() if one.type == "fixed"]
        frame = root.find("ros2_control/sensor/param[@name='frame']")
        assert frame is not None  # a robot without a camera has no RobotSpec
        return cls(
            (*fixed, Link(base, settings.scan_frame_id, scan, np.zeros(3))),
            tuple(_link(joints[joint.name]) for joint in spec.joints),
            (frame.text or "").strip(),
        )


def turned_by(link: Link, angle: float) -> Array:
    """Parent from child (4, 4) of a wheel at a position [rad] (Rodrigues' formula)."""
    x, y, z = link.axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    turn = np.eye(4)
    turn[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    found: Array = link.parent_from_child @ turn
    return found


def _link(joint: Any) -> Link:
    """Of a joint as yourdfpy has it."""
    origin = np.eye(4) if joint.origin is None else np.asarray(joint.origin, dtype=np.float64)
    axis = np.zeros(3) if joint.axis is None else np.asarray(joint.axis, dtype=np.float64)
    return Link(joint.parent, joint.child, origin, axis)
