"""Driven wheels in a robot description: how they are wired, where they are, how big they are.

The <ros2_control> block says which joints are driven, with the Build HAT's port and direction as
parameters of the joint; the joint says where the wheel is, and its link's shape how big it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import numpy as np

from robot.description.urdf import SpecError, child, numbers, origin_of, positive, shape_of, text_of
from robot.geometry import Array

ROBOT_FRAME = "base_footprint"
"""The link on the floor under the middle of the axle: what the program calls the robot frame."""

PORTS = ("A", "B", "C", "D")
TOLERANCE = 1e-6
"""How well typed lengths must agree [m]."""


@dataclass(frozen=True, slots=True)
class JointSpec:
    """One driven wheel; positive velocity drives the robot forward."""

    name: str
    port: str
    """Build HAT port, A to D."""
    direction: int
    """+1, or -1 where the motor is mounted the other way round."""
    radius: float
    """Wheel radius [m]."""
    offset: float
    """Wheel centre to the left of the robot frame's x axis [m]; negative is right."""
    max_velocity: float
    """[rad/s]"""
    max_effort: float
    """[N m]"""


def read_wheels(root: ElementTree.Element, model: Any) -> tuple[JointSpec, ...]:
    """The driven joints in the order of the <ros2_control> block.

    Raises:
        SpecError: not exactly two, or one that cannot be; names it and what would be valid.
    """
    driven = [
        joint
        for control in root.findall("ros2_control")
        for joint in control.findall("joint")
        if _velocity_command(joint) is not None
    ]
    if len(driven) != 2:
        raise SpecError(
            f"<ros2_control> has {len(driven)} joints with a velocity command interface; "
            "a differential drive has two, a left and a right wheel"
        )
    wheels = tuple(_read_wheel(root, model, joint) for joint in driven)
    _check_pair(*wheels)
    return wheels


def _velocity_command(joint: ElementTree.Element) -> ElementTree.Element | None:
    return joint.find("command_interface[@name='velocity']")


def _read_wheel(root: ElementTree.Element, model: Any, control: ElementTree.Element) -> JointSpec:
    name = str(control.get("name"))
    where = f"joint {name!r}"
    joint = find_joint(root, name)
    radius = _radius(_wheel_link(root, joint))
    limit = child(joint, "limit", where)
    max_velocity = positive(limit, "velocity", where)
    _check_command_range(control, max_velocity, where)
    return JointSpec(
        name=name,
        port=_port(control, where),
        direction=_direction(control, where),
        radius=radius,
        offset=_offset(model, joint, radius),
        max_velocity=max_velocity,
        max_effort=positive(limit, "effort", where),
    )


def find_joint(root: ElementTree.Element, name: str) -> ElementTree.Element:
    """The continuous <joint> of that name.

    Raises:
        SpecError: there is none; names those there are.
    """
    continuous = [joint for joint in root.findall("joint") if joint.get("type") == "continuous"]
    for joint in continuous:
        if joint.get("name") == name:
            return joint
    valid = ", ".join(str(joint.get("name")) for joint in continuous) or "none"
    raise SpecError(f"no continuous joint is called {name!r}; there are: {valid}")


def _wheel_link(root: ElementTree.Element, joint: ElementTree.Element) -> ElementTree.Element:
    name = child(joint, "child", f"joint {joint.get('name')!r}").get("link")
    for link in root.findall("link"):
        if link.get("name") == name:
            return link
    raise SpecError(f"joint {joint.get('name')!r}: there is no link {name!r}")


def _radius(link: ElementTree.Element) -> float:
    """Radius of the wheel's visual; what touches the floor must be as big."""
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


def _offset(model: Any, joint: ElementTree.Element, radius: float) -> float:
    """Where the wheel is; it must stand on the floor beside the robot frame's origin."""
    where = f"joint {joint.get('name')!r}"
    axis = child(joint, "axis", where)
    turned = origin_of(joint, where)[:3, :3] @ numbers(axis, "xyz", 3, where)
    if not np.allclose(turned, [0, 1, 0], atol=TOLERANCE):
        raise SpecError(f"{where}: the axis must be '0 1 0', so that positive drives forward")
    wheel = child(joint, "child", where).get("link")
    x, y, z = model.get_transform(wheel, ROBOT_FRAME)[:3, 3]
    if abs(x) > TOLERANCE:
        raise SpecError(f"{where} is {x:g} m ahead of {ROBOT_FRAME}, which is under the axle: 0 m")
    if abs(z - radius) > TOLERANCE:
        raise SpecError(f"{where} is {z:g} m above the floor, but the wheel's radius is {radius:g}")
    return float(y)


def _port(control: ElementTree.Element, where: str) -> str:
    port = text_of(control, "port", where)
    if port not in PORTS:
        raise SpecError(f"{where}: port is {port!r}; valid are {', '.join(PORTS)}")
    return port


def _direction(control: ElementTree.Element, where: str) -> int:
    text = text_of(control, "direction", where)
    if text not in ("1", "+1", "-1"):
        raise SpecError(f"{where}: direction is {text!r}; valid are 1 and -1")
    return int(text)


def _check_command_range(control: ElementTree.Element, limit: float, where: str) -> None:
    """The command interface's min and max, where given, must be the joint's limit."""
    command = _velocity_command(control)
    assert command is not None
    for name, valid in (("min", -limit), ("max", limit)):
        if command.find(f"param[@name='{name}']") is None:
            continue
        text = text_of(command, name, where)
        try:
            agrees = abs(float(text) - valid) < TOLERANCE
        except ValueError:
            agrees = False
        if not agrees:
            raise SpecError(f"{where}: {name} is {text!r}; by the joint's limit it is {valid:g}")


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


def resize_wheel(root: ElementTree.Element, model: Any, wheel: JointSpec) -> None:
    """Give a wheel of the description the radius and offset of ``wheel``, standing on the floor."""
    joint = find_joint(root, wheel.name)
    link = _wheel_link(root, joint)
    for solid in [*link.iter("cylinder"), *link.iter("sphere")]:
        solid.set("radius", repr(wheel.radius))
    holder = child(joint, "parent", wheel.name).get("link")
    holder_from_robot: Array = np.linalg.inv(model.get_transform(holder, ROBOT_FRAME))
    at = holder_from_robot @ np.array([0.0, wheel.offset, wheel.radius, 1.0])
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    origin.set("xyz", " ".join(repr(float(value)) for value in at[:3]))
