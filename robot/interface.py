"""The seam between the program and a robot, at the height of the joints.

A simulator, a fake and the Build HAT are all a ``Robot``; nothing above this seam knows which.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from robot.description.spec import RobotSpec
from robot.geometry import Array, Pose2


class RobotError(RuntimeError):
    """The robot cannot go on: unplugged, silent or broken."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One camera picture."""

    stamp: float
    """Middle of the exposure of the middle row, on the robot's clock [s]."""
    image: NDArray[np.uint8] = field(repr=False)
    """(h, w) grey or (h, w, 3) BGR, read-only."""

    def __post_init__(self) -> None:
        self.image.setflags(write=False)


@dataclass(frozen=True, slots=True)
class Reading:
    """One answer of the robot."""

    stamp: float
    """When the joints were read, on the robot's clock [s]."""
    positions: Array
    """Joint positions (j,) [rad], in the order of ``RobotSpec.joints``, never wrapped."""
    velocities: Array
    """Joint velocities (j,) [rad/s]."""
    frame: Frame | None = None
    """A camera picture that was not handed out before."""
    battery_v: float | None = None
    """Supply voltage [V], where it is measured."""
    truth: Pose2 | None = None
    """The true pose in the map; only a simulator knows it, only views and evaluation look."""
    connected: bool = True
    """Whether the joints answer and follow; the robot stands while they do not."""
    faults: tuple[str, ...] = ()
    """What is wrong with joints or camera now, each with its cure, in plain words."""


@runtime_checkable
class Robot(Protocol):
    """Something with driven joints and a camera."""

    name: str
    """What the dashboard calls it."""
    spec: RobotSpec

    def read(self) -> Reading:
        """Wait for the next reading; this sets the pace of the program.

        Raises:
            RobotError: the robot does not answer any more.
        """
        ...

    def write(self, velocities: Array) -> Array:
        """Ask for joint velocities (j,) [rad/s]; returns those really applied after limits.

        Ask again after every reading: a real robot stands when a fifth of a second goes by without.
        """
        ...

    def close(self) -> None:
        """Stop the joints and let go of the hardware; may be called twice."""
        ...


@runtime_checkable
class Placeable(Protocol):
    """A robot that can be put elsewhere by hand: what only a simulator can do."""

    def place(self, pose: Pose2) -> None:
        """Put the robot at a pose in the map, standing."""
        ...
