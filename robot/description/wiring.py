"""Wiring of the motors, as ros2_control describes hardware: a joint's port, direction, kind.

A robot with another shape or another number of joints has another URDF with the same block.
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree

from robot.description.urdf import SpecError, child, positive, text_of

MOTORS = ("small angular", "medium angular", "large angular")
"""The kinds with an encoder; a joint of the description names one of them as its ``motor``."""
OTHERS = {
    0x01: "simple medium motor (45303): it has no encoder",
    0x02: "train motor (88011): it has no encoder",
    0x26: "medium linear motor (88008)",
    0x2E: "Technic large motor (88013)",
    0x2F: "Technic XL motor (88014)",
    0x3D: "colour sensor",
    0x3E: "distance sensor",
    0x3F: "force sensor",
    0x40: "light matrix",
}
"""Names of other devices that may be plugged in, by type id."""
PORTS = ("A", "B", "C", "D")
TOLERANCE = 1e-6
"""Largest difference of typed lengths that must agree [m]."""


@dataclass(frozen=True, slots=True)
class MotorKind:
    """One type of motor."""

    type_id: int
    kind: str
    """One of ``MOTORS``."""
    lego_number: str
    """LEGO's part number."""
    free_speed: float
    """Speed at full duty and 7.2 V without load and friction [degree/s]."""
    time_constant: float
    """Time constant of the speed after a step of the duty [s]."""
    friction: float
    """Duty that Coulomb friction takes while the motor turns."""
    breakaway: float
    """Duty at which a standing motor begins to turn."""


KINDS = {
    item.type_id: item
    for item in (
        MotorKind(0x41, "small angular", "45607", 1070.0, 0.035, 0.12, 0.135),
        MotorKind(0x30, "medium angular", "45603", 1100.0, 0.036, 0.13, 0.145),
        MotorKind(0x31, "large angular", "45602", 1000.0, 0.048, 0.055, 0.105),
        MotorKind(0x4B, "medium angular", "88018", 1100.0, 0.036, 0.13, 0.145),
        MotorKind(0x4C, "large angular", "88017", 1000.0, 0.048, 0.055, 0.105),
    )
}
"""Motor kinds by type id. The figures are from Pybricks' measurements; those of LEGO's own sheets
(tolerance 15 %) are 10 to 17 % higher."""


def described(type_id: int) -> str:
    """Return the name of a device for messages."""
    known = KINDS.get(type_id)
    if known is not None:
        return f"{known.kind} motor ({known.lego_number})"
    return OTHERS.get(type_id, f"device of type {type_id:02X}")


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
