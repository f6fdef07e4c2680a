"""Wiring of the motors, as ros2_control describes hardware: a joint's port, direction, kind.

A robot with another shape or another number of joints has another URDF with the same block.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

from robot.description.motor_kinds import MOTORS
from robot.description.urdf import SpecError, child, positive, text_of

PORTS = ("A", "B", "C", "D")
TOLERANCE = 1e-6
"""Largest difference of typed lengths that must agree [m]."""


@dataclass(frozen=True, slots=True)
class Wiring:
    """One driven joint and the motor that drives it."""

    name: str
    port: str
    """Build HAT port, A to D."""
    direction: int
    """+1, or -1 where the motor is mounted the other way round."""
    motor: str | None
    """One of ``MOTORS``; None accepts any motor that has an encoder."""
    max_velocity: float
    """[rad/s]"""


def driven(root: ElementTree.Element) -> list[ElementTree.Element]:
    """Return the joints in <ros2_control> blocks that take velocity commands."""
    return [
        joint
        for control in root.findall("ros2_control")
        for joint in control.findall("joint")
        if velocity_command(joint) is not None
    ]


def velocity_command(joint: ElementTree.Element) -> ElementTree.Element | None:
    """Return a joint's velocity command interface in its <ros2_control> block, if it has one."""
    return joint.find("command_interface[@name='velocity']")


def read_wiring(root: ElementTree.Element, control: ElementTree.Element) -> Wiring:
    """Read one joint of a <ros2_control> block.

    Raises:
        SpecError: a parameter is missing or invalid; the message says what is valid.
    """
    name = str(control.get("name"))
    where = f"joint {name!r}"
    limit = child(find_joint(root, name), "limit", where)
    max_velocity = positive(limit, "velocity", where)
    _check_command_range(control, max_velocity, where)
    return Wiring(
        name,
        _port(control, where),
        _direction(control, where),
        _motor(control, where),
        max_velocity,
    )


def find_joint(root: ElementTree.Element, name: str) -> ElementTree.Element:
    """Return the continuous <joint> with that name.

    Raises:
        SpecError: no such joint exists; the message names the existing ones.
    """
    continuous = [joint for joint in root.findall("joint") if joint.get("type") == "continuous"]
    for joint in continuous:
        if joint.get("name") == name:
            return joint
    valid = ", ".join(str(joint.get("name")) for joint in continuous) or "none"
    raise SpecError(f"no continuous joint is called {name!r}; there are: {valid}")


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


def _motor(control: ElementTree.Element, where: str) -> str | None:
    if control.find("param[@name='motor']") is None:
        return None
    motor = text_of(control, "motor", where)
    if motor not in MOTORS:
        raise SpecError(f"{where}: motor is {motor!r}; valid are {', '.join(MOTORS)}")
    return motor


def _check_command_range(control: ElementTree.Element, limit: float, where: str) -> None:
    """Check that the command interface's min and max, if given, equal the joint's limit."""
    command = velocity_command(control)
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
