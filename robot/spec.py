"""The robot's description: every dimension of the program comes from here."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from robot.camera import FloorView, Lens
from robot.geometry import Array

SPIKE = Path(__file__).parent / "description" / "spike.urdf"


class SpecError(ValueError):
    """A robot description that cannot be used; the message says what is missing where."""


@dataclass(frozen=True, slots=True)
class JointSpec:
    """One driven wheel."""

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


@dataclass(frozen=True)
class RobotSpec:
    """A differential-drive robot with one camera, read from a URDF and a lens file."""

    name: str
    joints: tuple[JointSpec, ...]
    """The order of all joint arrays."""
    lens: Lens
    robot_from_camera: Array = field(repr=False)
    """(4, 4), from the camera's optical frame to the robot frame on the floor."""
    urdf: str = field(repr=False)
    """The description as text, with inertia filled in."""
