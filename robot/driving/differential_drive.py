"""Two driven wheels on one axle: from the robot's velocity to the wheels' and back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robot.description.spec import RobotSpec
from robot.geometry import Array, Pose2, Twist2


class WheelMultipliers(NamedTuple):
    """Measured dimensions by described ones (diff_drive_controller's ``*_multiplier``)."""

    left_radius: float = 1.0
    right_radius: float = 1.0
    separation: float = 1.0


class DifferentialDrive:
    """Kinematics of rolling without slip (Siegwart et al. 2011, ch. 3.2).

    The floor under a wheel at ``y`` to the left of the robot's origin passes at
    ``v - omega y``, which the wheel rolls off at ``r`` times its angular velocity.
    """

    def __init__(self, spec: RobotSpec, multipliers: WheelMultipliers | None = None) -> None:
        by = multipliers or WheelMultipliers()
        self.spec = spec
        self.left, self.right = spec.axle
        self.track = by.separation * spec.track
        """Distance between the wheels [m], as corrected."""
        radii = np.array([joint.radius for joint in spec.joints])
        radii[[self.left, self.right]] *= by.left_radius, by.right_radius
        self.radii = radii
        """Of the wheels (j,) [m], as corrected."""
        offsets = by.separation * np.array([joint.offset for joint in spec.joints])
        self._limits = np.array([joint.max_velocity for joint in spec.joints])
        self._wheels_from_twist = np.column_stack([1 / radii, -offsets / radii])
        self._twist_from_wheels = np.linalg.inv(self._wheels_from_twist)

    def wheels(self, twist: Twist2) -> Array:
        """Joint velocities (j,) [rad/s] that give a twist."""
        velocities: Array = self._wheels_from_twist @ (twist.v, twist.omega)
        return velocities

    def twist(self, velocities: Array) -> Twist2:
        """The twist that joint velocities (j,) [rad/s] give."""
        v, omega = self._twist_from_wheels @ velocities
        return Twist2(float(v), float(omega))

    def moved(self, turned: Array) -> Pose2:
        """Where the robot is, seen from before, after joints turned by (j,) [rad] evenly."""
        return self.twist(turned).integrate(1.0)

    def limit(self, twist: Twist2) -> Twist2:
        """The twist slowed down so that no wheel passes its limit, on the same curve."""
        excess = float(np.max(np.abs(self.wheels(twist)) / self._limits))
        return twist if excess <= 1 else Twist2(twist.v / excess, twist.omega / excess)
