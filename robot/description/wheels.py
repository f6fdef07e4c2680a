"""Driven wheels in a robot description: their wiring, positions and radii.

The <ros2_control> block says which joints are driven; the Build HAT's port and direction are
parameters of the joint. The joint gives the wheel's position. The shape of its link gives the
radius.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from xml.etree import ElementTree

import numpy as np

from robot.description.robot_model import RobotModel
from robot.description.urdf import SpecError, child, numbers, origin_of, positive, shape_of
from robot.description.wiring import TOLERANCE, Wiring, driven, find_joint, read_wiring

ROBOT_FRAME = "base_footprint"
"""The link on the floor under the middle of the axle; the program calls it the robot frame."""


@dataclass(frozen=True, slots=True)
class JointSpec(Wiring):
    """One driven wheel; positive velocity drives the robot forward."""

    radius: float
    """Wheel radius [m]."""
    offset: float
    """Distance from the robot frame's x axis to the wheel's centre [m]; positive is left."""
    max_effort: float
    """[N m]"""


def read_wheels(root: ElementTree.Element, model: RobotModel) -> tuple[JointSpec, ...]:
    """Return the driven joints in the order of the <ros2_control> block.

    Raises:
        SpecError: there are not exactly two, or one is invalid; the message says which, and what
            is valid.
    """
    controls = driven(root)
    if len(controls) != 2:
        raise SpecError(
            f"<ros2_control> has {len(controls)} joints with a velocity command interface; "
            "a differential drive has two, a left and a right wheel"
        )
    wheels = tuple(_read_wheel(root, model, joint) for joint in controls)
    _check_pair(*wheels)
    return wheels


def _read_wheel(
    root: ElementTree.Element, model: RobotModel, control: ElementTree.Element
) -> JointSpec:
    wiring = read_wiring(root, control)
    joint = find_joint(root, wiring.name)
    radius = _radius(_wheel_link(root, joint))
    limit = child(joint, "limit", f"joint {wiring.name!r}")
    return JointSpec(
        **asdict(wiring),
        radius=radius,
        offset=_offset(model, joint, radius),
        max_effort=positive(limit, "effort", f"joint {wiring.name!r}"),
    )


def _wheel_link(root: ElementTree.Element, joint: ElementTree.Element) -> ElementTree.Element:
    name = child(joint, "child", f"joint {joint.get('name')!r}").get("link")
    for link in root.findall("link"):
        if link.get("name") == name:
            return link
    raise SpecError(f"joint {joint.get('name')!r}: there is no link {name!r}")


def _radius(link: ElementTree.Element) -> float:
    """Return the radius of the wheel's visual; its collision shapes must have the same radius."""
    where = f"wheel {link.get('name')!r}"
    visual = child(link, "visual", where)
    shape = shape_of(visual, where)
    if shape.kind == "box":
        raise SpecError(f"{where} is a box; valid are cylinder and sphere")
    across = abs(float(origin_of(visual, where)[1, 2]))
    if shape.kind == "cylinder" and across < 1 - TOLERANCE:
        raise SpecError(f"{where}: the cylinder must lie along y, so turned by rpy='1.5708 0 0'")
    for collision in link.findall("collision"):
        touching = shape_of(collision, where)
        if touching.kind == "box" or abs(touching.size[0] - shape.size[0]) > TOLERANCE:
            raise SpecError(f"{where}: the collision must have the visual's radius {shape.size[0]}")
    return shape.size[0]


def _offset(model: RobotModel, joint: ElementTree.Element, radius: float) -> float:
    """Return the wheel's offset; the wheel must stand on the floor beside the frame's origin."""
    where = f"joint {joint.get('name')!r}"
    axis = child(joint, "axis", where)
    turned = origin_of(joint, where)[:3, :3] @ numbers(axis, "xyz", 3, where)
    if not np.allclose(turned, [0, 1, 0], atol=TOLERANCE):
        raise SpecError(f"{where}: the axis must be '0 1 0', so that positive drives forward")
    wheel = str(child(joint, "child", where).get("link"))
    x, y, z = model.transform(wheel, ROBOT_FRAME)[:3, 3]
    if abs(x) > TOLERANCE:
        raise SpecError(f"{where} is {x:g} m ahead of {ROBOT_FRAME}, which is under the axle: 0 m")
    if abs(z - radius) > TOLERANCE:
        raise SpecError(f"{where} is {z:g} m above the floor, but the wheel's radius is {radius:g}")
    return float(y)


def _check_pair(first: JointSpec, second: JointSpec) -> None:
    if first.name == second.name:
        raise SpecError(f"joint {first.name!r} is listed twice; left and right wheel differ")
    if first.port == second.port:
        raise SpecError(f"both wheels are on port {first.port}; each needs its own of A to D")
    if abs(first.offset + second.offset) > TOLERANCE or abs(first.offset) < TOLERANCE:
        raise SpecError(
            f"the wheels are {first.offset:g} and {second.offset:g} m to the left; "
            f"{ROBOT_FRAME} must lie in the middle between them"
        )


def resize_wheel(root: ElementTree.Element, model: RobotModel, wheel: JointSpec) -> None:
    """Set the description's wheel to the radius and offset of ``wheel``, standing on the floor."""
    joint = find_joint(root, wheel.name)
    link = _wheel_link(root, joint)
    for solid in [*link.iter("cylinder"), *link.iter("sphere")]:
        solid.set("radius", repr(wheel.radius))
    holder = str(child(joint, "parent", wheel.name).get("link"))
    holder_from_robot = model.transform(ROBOT_FRAME, holder)
    position = holder_from_robot @ np.array([0.0, wheel.offset, wheel.radius, 1.0])
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    origin.set("xyz", " ".join(repr(float(value)) for value in position[:3]))
