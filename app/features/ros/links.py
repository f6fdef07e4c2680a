"""Transforms between the robot's links, as robot_state_publisher would publish them."""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.spatial.transform import Rotation

from app.settings.groups import Ros2Settings
from robot.description.robot_model import Joint, read_model
from robot.description.spec import RobotSpec
from robot.description.urdf import parse_xml
from robot.settings import SettingError

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""x, y, z, w"""


@dataclass(frozen=True)
class PlacedLink:
    """One link, with its pose relative to its parent."""

    parent: str
    child: str
    place: Vector
    """Position in the parent's frame [m]."""
    turn: Quaternion = (0.0, 0.0, 0.0, 1.0)
    """Rotation relative to the parent; of a wheel, at joint position zero."""
    axis: Vector = (0.0, 0.0, 0.0)
    """Rotation axis of a wheel: a unit vector in the wheel's own frame."""

    def inverse(self) -> PlacedLink:
        """Return the inverse: the parent, relative to the child."""
        x, y, z, w = self.turn
        moved = Rotation.from_quat(self.turn).inv().apply(self.place)
        back = (-float(moved[0]), -float(moved[1]), -float(moved[2]))
        return PlacedLink(self.child, self.parent, back, (-x, -y, -z, w))

    def turned(self, angle: float) -> Quaternion:
        """Rotation of a wheel at a joint position [rad]: the product of two quaternions."""
        x, y, z, w = self.turn
        sine, cosine = math.sin(angle / 2), math.cos(angle / 2)
        a, b, c = (sine * axi for axi in self.axis)
        return (
            w * a + x * cosine + y * c - z * b,
            w * b + y * cosine + z * a - x * c,
            w * c + z * cosine + x * b - y * a,
            w * cosine - x * a - y * b - z * c,
        )


@dataclass(frozen=True)
class Links:
    """All links of a robot."""

    fixed: tuple[PlacedLink, ...]
    wheels: tuple[PlacedLink, ...]
    """In the order of the joints."""
    camera: str
    """The frame of the camera's pictures."""

    @classmethod
    def of(cls, spec: RobotSpec, settings: Ros2Settings, scan_x: float) -> Links:
        """Return the links of a robot description.

        Args:
            scan_x: how far in front of the robot's origin scans start [m].

        Raises:
            SettingError: with these names, a frame would have two parents or a wrong position.
        """
        model = read_model(spec.urdf)
        joints = {joint.name: joint for joint in model.joints}
        root, base = parse_xml(spec.urdf), settings.base_frame_id
        fixed = [_link(item) for item in joints.values() if item.type == "fixed"]
        fixed = _rooted_at(base, fixed, model.root, set(model.names))
        if settings.scan_frame_id != base or scan_x:
            _check_new(settings.scan_frame_id, {base, *model.names})
            fixed.append(PlacedLink(base, settings.scan_frame_id, (scan_x, 0.0, 0.0)))
        frame = root.find("ros2_control/sensor/param[@name='frame']")
        assert frame is not None  # every RobotSpec has a camera
        return cls(
            tuple(fixed),
            tuple(_link(joints[joint.name]) for joint in spec.joints),
            (frame.text or "").strip(),
        )


def _rooted_at(base: str, fixed: list[PlacedLink], root: str, names: set[str]) -> list[PlacedLink]:
    """Put the robot's frame at the top of the fixed links, because a frame has one parent."""
    if base == root:
        return fixed
    if base not in names:
        return [PlacedLink(base, root, (0.0, 0.0, 0.0)), *fixed]
    above = {item.child: item for item in fixed}.get(base)
    if above is None or above.parent != root or above != _upright(above):
        valid = [each.child for each in fixed if each.parent == root and each == _upright(each)]
        raise SettingError(
            f"ros2.base_frame_id is {base!r}, which is not the robot's place on the floor; valid "
            f"are {', '.join([root, *valid])}, or a name that no link has"
        )
    return [transform.inverse() if transform is above else transform for transform in fixed]


def _upright(link: PlacedLink) -> PlacedLink:
    """The link moved straight above its parent, at the same height and without rotation."""
    return PlacedLink(link.parent, link.child, (0.0, 0.0, link.place[2]), axis=link.axis)


def _check_new(scan: str, names: set[str]) -> None:
    if scan in names:
        raise SettingError(
            f"ros2.scan_frame_id is {scan!r}, which is a link already; valid is a name that no "
            "link has"
        )


def _link(joint: Joint) -> PlacedLink:
    """Convert a joint of the description."""
    x, y, z = joint.origin[:3, 3].tolist()
    qx, qy, qz, qw = Rotation.from_matrix(joint.origin[:3, :3]).as_quat().tolist()
    ax, ay, az = joint.axis.tolist()
    return PlacedLink(joint.parent, joint.child, (x, y, z), (qx, qy, qz, qw), (ax, ay, az))
