"""What a simulated world offers: a body on wheels that can be stepped, put elsewhere and asked."""

from __future__ import annotations

import math
from typing import Protocol, runtime_checkable

from robot.description.spec import RobotSpec
from robot.geometry import Array, Pose2, Twist2


class WorldError(ValueError):
    """A simulated world was asked for something that cannot be."""


@runtime_checkable
class World(Protocol):
    """One robot on an endless level floor, in the map frame; it has no clock but its steps."""

    @property
    def step_time(self) -> float:
        """Simulated time of one step [s]."""
        ...

    def place(self, pose: Pose2) -> None:
        """Put the robot at a pose in the map, standing; joint positions are kept.

        Raises:
            WorldError: the pose is not finite.
        """
        ...

    def step(self, velocities: Array) -> None:
        """One step on, towards commanded joint velocities (j,) [rad/s], limited to the motors'.

        Raises:
            WorldError: another count of velocities, or not finite; nothing has moved then.
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
        """Let go of everything; may be called twice, and nothing else after it."""
        ...


def limited(spec: RobotSpec, velocities: Array) -> list[float]:
    """Commanded joint velocities (j,) [rad/s], each brought within its motor's limit.

    Plain numbers come back: for two of them numpy takes longer than the rest of a step.

    Raises:
        WorldError: another count of velocities, or not finite.
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
        WorldError: names the pose.
    """
    if not pose.is_finite():
        raise WorldError(f"{pose} is not finite")
