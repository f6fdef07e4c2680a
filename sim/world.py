"""Simulated worlds: the interface of a robot that is stepped and placed; and one without forces."""

from __future__ import annotations

import math
from typing import Protocol, runtime_checkable

import numpy as np

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.errors import BrickPoseError
from robot.geometry import Array, Pose2, Twist2


class WorldError(BrickPoseError, ValueError):
    """A simulated world cannot do what was asked."""


@runtime_checkable
class World(Protocol):
    """One robot on an endless level floor, in the map frame; time passes only in its steps."""

    @property
    def step_time(self) -> float:
        """Simulated time of one step [s]."""
        ...

    def place(self, pose: Pose2) -> None:
        """Place the robot at a pose in the map, at rest; joint positions are kept.

        Raises:
            WorldError: the pose is not finite.
        """
        ...

    def step(self, velocities: Array, steps: int = 1) -> None:
        """Advance towards joint velocities (j,) [rad/s], clipped to the motors' limits.

        Several steps at once give the same motion as one by one, and may be quicker.

        Raises:
            WorldError: the number of velocities is wrong, or one is not finite; nothing moves then.
        """
        ...

    @property
    def pose(self) -> Pose2:
        """True pose of the robot frame in the map."""
        ...

    @property
    def twist(self) -> Twist2:
        """True velocity, in the robot frame."""
        ...

    @property
    def positions(self) -> Array:
        """True joint positions (j,) [rad], never wrapped."""
        ...

    @property
    def velocities(self) -> Array:
        """True joint velocities (j,) [rad/s]."""
        ...

    @property
    def tilt(self) -> float:
        """Angle between the robot's z axis and the vertical [rad]."""
        ...

    def close(self) -> None:
        """Release all resources; may be called twice. Nothing else may be called afterwards."""
        ...


def limited(spec: RobotSpec, velocities: Array) -> list[float]:
    """Return commanded joint velocities (j,) [rad/s], each clipped to its motor's limit.

    The result is a plain list: for two numbers, numpy takes longer than the rest of a step.

    Raises:
        WorldError: the number of velocities is wrong, or one is not finite.
    """
    if velocities.shape != (len(spec.joints),):
        names = ", ".join(joint.name for joint in spec.joints)
        raise WorldError(f"velocities of shape {velocities.shape}; expected one each for {names}")
    wanted = velocities.tolist()
    if not all(map(math.isfinite, wanted)):
        raise WorldError(f"joint velocities {wanted} are not finite")
    return [
        min(max(velocity, -joint.max_velocity), joint.max_velocity)
        for velocity, joint in zip(wanted, spec.joints, strict=True)
    ]


def check_pose(pose: Pose2) -> None:
    """Refuse a pose that is not finite.

    Raises:
        WorldError: the pose is not finite; names the pose.
    """
    if not pose.is_finite():
        raise WorldError(f"{pose} is not finite")


class KinematicWorld:
    """Without forces: wheels roll as they turn, at once as fast as commanded; a ``World``."""

    def __init__(
        self, spec: RobotSpec, start: Pose2 | None = None, *, step_time: float = 0.002
    ) -> None:
        self.step_time = step_time
        self._spec = spec
        self._drive = DifferentialDrive(spec)
        self._positions = np.zeros(len(spec.joints))
        self.place(start or Pose2())

    def place(self, pose: Pose2) -> None:
        """Place the robot at a pose in the map, at rest; joint positions are kept."""
        check_pose(pose)
        self._pose = pose
        self._velocities = np.zeros(len(self._spec.joints))

    def step(self, velocities: Array, steps: int = 1) -> None:
        """Advance at joint velocities (j,) [rad/s], clipped to the motors' limits."""
        self._velocities = np.array(limited(self._spec, velocities))
        if not self._velocities.any():
            return
        turned = self._velocities * self.step_time
        moved = self._drive.moved(turned)
        for _ in range(steps):
            self._positions += turned
            self._pose = self._pose @ moved

    @property
    def pose(self) -> Pose2:
        """Pose of the robot frame in the map."""
        return self._pose

    @property
    def twist(self) -> Twist2:
        """Velocity, in the robot frame."""
        return self._drive.twist(self._velocities)

    @property
    def positions(self) -> Array:
        """Joint positions (j,) [rad], never wrapped."""
        return self._positions.copy()

    @property
    def velocities(self) -> Array:
        """Joint velocities (j,) [rad/s]."""
        return self._velocities.copy()

    @property
    def tilt(self) -> float:
        """Tilt [rad]: always 0."""
        return 0.0

    def close(self) -> None:
        """Do nothing: the world holds no resources."""
