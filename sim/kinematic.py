"""World without forces: wheels turn as commanded and never slip."""

from __future__ import annotations

import numpy as np

from robot.description.spec import RobotSpec
from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Array, Pose2, Twist2
from sim.world import check_pose, limited


class KinematicWorld:
    """The perfect robot: exact arcs, motors that reach their speed at once; a ``World``."""

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

    def step(self, velocities: Array) -> None:
        """Advance one step at joint velocities (j,) [rad/s], clipped to the motors' limits."""
        self._velocities = np.array(limited(self._spec, velocities))
        turned = self._velocities * self.step_time
        self._positions += turned
        self._pose = self._pose @ self._drive.moved(turned)

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
