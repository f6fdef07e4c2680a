"""Interface of a simulated world: a robot on wheels that can be stepped, placed and measured."""

from __future__ import annotations

import math
from typing import Protocol, runtime_checkable

from robot.description.spec import RobotSpec
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

    def step(self, velocities: Array) -> None:
        """Advance one step towards joint velocities (j,) [rad/s], clipped to the motors' limits.

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
