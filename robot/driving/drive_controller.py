"""Applies limits, ramps and a time-out to velocity commands.

Behaves like ros2_control's diff_drive_controller: speed and acceleration of both axes are limited,
and a command that is not renewed ends.
"""

from __future__ import annotations

from dataclasses import dataclass

from robot.driving.differential_drive import DifferentialDrive, WheelMultipliers
from robot.geometry import Twist2
from robot.settings import check_settings, setting

ROUNDING_S = 5e-7
"""Tolerance of times [s]: stamps are sums of floating-point periods."""


@dataclass(frozen=True)
class DriveSettings:
    """Limits of the drive, and how the wheels are corrected, as diff_drive_controller has them."""

    max_velocity: float = setting(0.30, "Highest speed", unit="m/s", low=0, high=2)
    max_acceleration: float = setting(
        0.6, "Speed gained in a second", unit="m/s^2", low=0.01, high=20
    )
    max_deceleration: float = setting(
        1.5, "Speed lost in a second", unit="m/s^2", low=0.01, high=20
    )
    max_angular_velocity: float = setting(
        2.5, "Highest turning speed", unit="rad/s", low=0, high=20
    )
    max_angular_acceleration: float = setting(
        8.0, "Turning speed gained in a second", unit="rad/s^2", low=0.05, high=200
    )
    max_angular_deceleration: float = setting(
        16.0, "Turning speed lost in a second", unit="rad/s^2", low=0.05, high=200
    )
    cmd_vel_timeout: float = setting(
        0.3, "A command that is not renewed ends after this time", unit="s", low=0.2, high=5
    )
    left_wheel_radius_multiplier: float = setting(
        1.0, "Factor on the described radius of the left wheel", low=0.5, high=2
    )
    right_wheel_radius_multiplier: float = setting(
        1.0, "Factor on the described radius of the right wheel", low=0.5, high=2
    )
    wheel_separation_multiplier: float = setting(
        1.0, "Factor on the described distance between the wheels", low=0.5, high=2
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def multipliers(self) -> WheelMultipliers:
        """Factors that correct the described wheels."""
        return WheelMultipliers(
            self.left_wheel_radius_multiplier,
            self.right_wheel_radius_multiplier,
            self.wheel_separation_multiplier,
        )


def lapsed(stamp: float, until: float) -> bool:
    """Return whether a time [s] is over."""
    return stamp > until - ROUNDING_S


class DriveController:
    """Holds the newest command and gives the twist to apply now."""

    def __init__(self, drive: DifferentialDrive, settings: DriveSettings) -> None:
        self.kinematics = drive
        """The wheels, which limit the speed."""
        self._settings = settings
        self._wanted = Twist2()
        self._until = float("-inf")
        self._applied = Twist2()
        self._stamp: float | None = None

    @property
    def active(self) -> bool:
        """Whether a command applies or the robot still slows down."""
        return self._wanted != Twist2() or self._applied != Twist2()

    def command(self, twist: Twist2, stamp: float) -> None:
        """Request a twist from ``stamp`` [s] until the time-out."""
        self._wanted = twist
        self._until = stamp + self._settings.cmd_vel_timeout

    def stop(self) -> None:
        """Stop at once, without a ramp."""
        self._wanted = self._applied = Twist2()

    def update(self, stamp: float) -> Twist2:
        """Return the twist to apply at a stamp [s]."""
        duration = 0.0 if self._stamp is None else max(stamp - self._stamp, 0.0)
        self._stamp = stamp
        if lapsed(stamp, self._until):
            # The command has timed out, so no time is left for a ramp.
            self.stop()
            return self._applied
        limits = self._settings
        v = _clamp(self._wanted.v, limits.max_velocity)
        omega = _clamp(self._wanted.omega, limits.max_angular_velocity)
        wanted = self.kinematics.limit(Twist2(v, omega))
        self._applied = Twist2(
            _ramp(
                self._applied.v,
                wanted.v,
                limits.max_acceleration * duration,
                limits.max_deceleration * duration,
            ),
            _ramp(
                self._applied.omega,
                wanted.omega,
                limits.max_angular_acceleration * duration,
                limits.max_angular_deceleration * duration,
            ),
        )
        return self._applied


def _clamp(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _ramp(current: float, wanted: float, gain: float, loss: float) -> float:
    """Return the speed one step on; slowing down may be faster than speeding up."""
    wanted_here = 0.0 if current * wanted < 0 else wanted  # pass through standstill first
    step = gain if abs(wanted_here) > abs(current) else loss
    return current + _clamp(wanted_here - current, step)
