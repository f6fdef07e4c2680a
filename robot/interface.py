"""The interface between the program and a robot, at the level of the joints.

A simulator, a fake and the Build HAT are all a ``Robot``; no code above this interface knows which.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from robot.description.spec import RobotSpec
from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2
from robot.scan import Scan


class RobotError(BrickPoseError, RuntimeError):
    """The robot cannot go on: unplugged, silent or broken."""


@dataclass(frozen=True, slots=True, eq=False)
class Frame:
    """One camera picture."""

    stamp: float
    """Middle of the exposure of the middle row, on the robot's clock [s]."""
    image: NDArray[np.uint8] = field(repr=False)
    """(h, w) grey or (h, w, 3) BGR, read-only."""

    def __post_init__(self) -> None:
        self.image.setflags(write=False)


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """One answer of the robot."""

    stamp: float
    """When the joints were read, on the robot's clock [s]."""
    positions: Array
    """Joint positions (j,) [rad], in the order of ``RobotSpec.joints``, never wrapped."""
    velocities: Array
    """Joint velocities (j,) [rad/s]."""
    frame: Frame | None = None
    """A camera picture that was not handed out before; None if there is no new one."""
    battery_v: float | None = None
    """Supply voltage [V]; None if it is not measured."""
    truth: Pose2 | None = None
    """The true pose in the map. Only a simulator knows it; only views and evaluation use it."""
    connected: bool = True
    """Whether the joints answer and follow commands; while they do not, the robot stands still."""
    faults: tuple[str, ...] = ()
    """What is wrong with joints or camera now, each with its cure, in plain words."""
    scan: Scan | None = None
    """A laser's scan that was not handed out before; None if there is no new one."""
    odom_from_robot: Pose2 | None = None
    """Pose in the odom frame, if the robot computes odometry itself; None: the joints tell it."""


@runtime_checkable
class Robot(Protocol):
    """A robot with driven joints, and a camera or a laser.

    ``tests/robot/test_robot_contract.py`` tests each robot by this contract.
    """

    name: str
    """Name of the robot on the dashboard."""
    spec: RobotSpec

    def read(self) -> Reading:
        """Wait for the next reading; this sets the pace of the program, fifty times a second.

        Each picture of the camera is in one reading, 25 to 31 of them a second. A simulator calls
        ``wait``, which its maker got, with the stamp of each reading: that makes it run in real
        time, or as fast as it can.

        Raises:
            RobotError: the robot does not answer any more.
        """
        ...

    def write(self, velocities: Array) -> Array:
        """Request joint velocities (j,) [rad/s]; return those that the robot applies.

        The robot itself limits them to ``max_velocity`` of each joint of ``spec``. After ``close``
        it applies, and returns, zeros. Request them again after every reading: a real robot stops
        after a fifth of a second without a request.
        """
        ...

    def close(self) -> None:
        """Stop the joints and release the hardware; may be called twice."""
        ...


@runtime_checkable
class PhysicalRobot(Protocol):
    """A robot that a physics engine moves, or moved when it was recorded."""

    @property
    def engine(self) -> str | None:
        """Name and version of the engine; None: the robot moved without forces."""
        ...


@runtime_checkable
class RestingRobot(Protocol):
    """A robot whose readings cost something to make, as those of a simulated one do."""

    def rest(self, period: float, wanted: Callable[[], object]) -> None:
        """Give a reading, with one picture, only each period [s], as it stands; 0: as usual.

        While ``wanted`` returns what is true, one is wanted at once.
        """
        ...


@runtime_checkable
class RepositionableRobot(Protocol):
    """A robot that can be put at any pose of the map; only a simulator can do this."""

    def place(self, pose: Pose2) -> None:
        """Put the robot at a pose in the map, at rest."""
        ...
