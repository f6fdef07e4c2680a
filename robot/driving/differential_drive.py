"""Differential drive, two wheels on an axle: from robot's to wheels' velocities, and back."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from robot.description.spec import RobotSpec
from robot.geometry import Array, Pose2, Twist2


class WheelMultipliers(NamedTuple):
    """Ratios of measured to described dimensions (diff_drive_controller's ``*_multiplier``)."""

    left_radius: float = 1.0
    right_radius: float = 1.0
    separation: float = 1.0


class DifferentialDrive:
    """Kinematics of rolling without slip (Siegwart et al. 2011, ch. 3.2).

    A wheel at ``y`` to the left of the robot's origin moves over the floor at ``v - omega y``.
    Without slip, this speed is ``r`` times the wheel's angular velocity.
    """

    def __init__(self, spec: RobotSpec, multipliers: WheelMultipliers | None = None) -> None:
        used = multipliers or WheelMultipliers()
        self.spec = spec
        self._multipliers = used
        self.left, self.right = spec.axle
        self.track = used.separation * spec.track
        """Corrected distance between the wheels [m]."""
        radii = np.array([joint.radius for joint in spec.joints])
        radii[[self.left, self.right]] *= used.left_radius, used.right_radius
        self.radii = radii
        """Corrected radii of the wheels (j,) [m]."""
        offsets = used.separation * np.array([joint.offset for joint in spec.joints])
        self.limits = np.array([joint.max_velocity for joint in spec.joints])
        """Fastest velocities of the joints (j,) [rad/s]."""
        self._wheels_from_twist = np.column_stack([1 / radii, -offsets / radii])
        self._twist_from_wheels = np.linalg.inv(self._wheels_from_twist)

    def of(self, spec: RobotSpec) -> DifferentialDrive:
        """Return the kinematics of a robot that was calibrated anew, with the same multipliers."""
        return DifferentialDrive(spec, self._multipliers)

    def wheels(self, twist: Twist2) -> Array:
        """Return the joint velocities (j,) [rad/s] that give a twist."""
        velocities: Array = self._wheels_from_twist @ (twist.v, twist.omega)
        return velocities

    def twist(self, velocities: Array) -> Twist2:
        """Return the twist that joint velocities (j,) [rad/s] give."""
        v, omega = self._twist_from_wheels @ velocities
        return Twist2(float(v), float(omega))

    def moved(self, turned: Array) -> Pose2:
        """Return the new pose in the old robot frame, after joints turned evenly by (j,) [rad]."""
        return self.twist(turned).integrate(1.0)

    def limit(self, twist: Twist2) -> Twist2:
        """Return the twist slowed down on the same curve, so that no wheel exceeds its limit."""
        excess = float(np.max(np.abs(self.wheels(twist)) / self.limits))
        return twist if excess <= 1 else Twist2(twist.v / excess, twist.omega / excess)
