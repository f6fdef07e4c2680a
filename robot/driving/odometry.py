"""Odometry: integrates wheel readings to poses with covariance, and remembers them by stamp."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import deque
from dataclasses import dataclass, field

import numpy as np

from robot.driving.differential_drive import DifferentialDrive
from robot.geometry import Array, Pose2, Twist2, interpolate
from robot.interface import Reading
from robot.settings import check_settings, setting

FASTER, AT_ONCE = 3.0, 0.5
"""A joint that has turned by so many times what it can, and so much more [rad], counts anew: its
plug was pulled, and it begins again at nought."""


@dataclass(frozen=True)
class OdometrySettings:
    """How far the wheels are trusted."""

    wheel_error: float = setting(
        0.0002,
        "Variance of a wheel's travel, by travel (Siegwart and Nourbakhsh 2004, eq. 5.8: k)",
        unit="m",
        low=0,
        high=1,
    )
    history: float = setting(1.0, "How long poses are remembered", unit="s", low=0.05, high=60)

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, eq=False)
class OdometryState:
    """Dead reckoning at one stamp."""

    stamp: float
    odom_from_robot: Pose2
    twist: Twist2
    """Twist measured by the wheels."""
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad] in the odom frame; it grows with every turn of a wheel."""


class Odometry:
    """Integrates wheel readings and returns where the robot was at a stamp."""

    def __init__(self, drive: DifferentialDrive, settings: OdometrySettings) -> None:
        self.drive = drive
        """The kinematics that the odometry uses."""
        self._settings = settings
        self._positions: Array | None = None
        self._history: deque[OdometryState] = deque()
        self._began = 0.0
        """Stamp of the first reading."""
        self.counted_anew = -math.inf
        """Stamp at which a joint was last elsewhere than it can have turned: it counts anew."""

    def update(self, reading: Reading) -> OdometryState:
        """Add one reading of the joints; return the new state.

        Raises:
            ValueError: the stamp is not later than the previous one.
        """
        if self._positions is None:
            self._began = reading.stamp
            pose = reading.odom_from_robot or Pose2()
            state = OdometryState(reading.stamp, pose, Twist2(), np.zeros((3, 3)))
        else:
            state = self._advance(self._history[-1], reading, reading.positions - self._positions)
        self._positions = reading.positions
        self._history.append(state)
        while len(self._history) > 2 and self._history[1].stamp < (
            reading.stamp - self._settings.history
        ):
            self._history.popleft()
        return state

    def at(self, stamp: float) -> OdometryState:
        """Return the state at a stamp, interpolated between two readings.

        After the last reading it is the last state. Up to the setting ``history`` before the very
        first reading it is the first state.

        Raises:
            LookupError: nothing was read yet, or the stamp is older than the remembered states.
        """
        if not self._history:
            raise LookupError("no wheel reading has come yet")
        earliest = self._history[0].stamp
        if earliest == self._began:
            earliest -= self._settings.history  # nothing is forgotten yet
        if stamp < earliest:
            raise LookupError(
                f"odometry at {stamp:.3f} s was asked; it is kept from "
                f"{self._history[0].stamp:.3f} to {self._history[-1].stamp:.3f} s"
            )
        after = bisect_right(self._history, stamp, key=lambda state: state.stamp)
        if after in (0, len(self._history)):
            return self._history[min(after, len(self._history) - 1)]
        low, high = self._history[after - 1], self._history[after]
        part = (stamp - low.stamp) / (high.stamp - low.stamp)
        pose = interpolate(low.odom_from_robot, high.odom_from_robot, part)
        # A reading's twist is the mean since the previous reading: use the later reading's twist.
        return OdometryState(stamp, pose, high.twist, low.covariance)

    def _advance(self, last: OdometryState, reading: Reading, turned: Array) -> OdometryState:
        duration = reading.stamp - last.stamp
        if not duration > 0:
            raise ValueError(
                f"a reading at {reading.stamp:.6f} s follows one at {last.stamp:.6f} s; "
                "stamps must rise"
            )
        most = FASTER * self.drive.limits * duration + AT_ONCE
        if (np.abs(turned) > most).any():
            self.counted_anew = reading.stamp
            turned = np.where(np.abs(turned) > most, reading.velocities * duration, turned)
        moved = self.drive.moved(turned)
        covariance = self._spread(last, turned, moved)
        twist = self.drive.twist(reading.velocities)
        pose = reading.odom_from_robot or last.odom_from_robot @ moved
        return OdometryState(reading.stamp, pose, twist, covariance)

    def _spread(self, last: OdometryState, turned: Array, moved: Pose2) -> Array:
        """Propagate the covariance over one step (Siegwart and Nourbakhsh 2004, eq. 5.9)."""
        track = self.drive.track
        travel = np.abs(turned) * self.drive.radii
        by_wheel = self._settings.wheel_error * travel
        heading = last.odom_from_robot.theta + moved.theta / 2
        cx, cy = np.cos(heading), np.sin(heading)
        left, right = self.drive.left, self.drive.right
        by_pose = np.array([[1, 0, -moved.x * cy], [0, 1, moved.x * cx], [0, 0, 1]])
        by_turn = np.empty((3, 2))
        by_turn[:, 0] = cx / 2, cy / 2, -1 / track
        by_turn[:, 1] = cx / 2, cy / 2, 1 / track
        noise = np.diag([by_wheel[left], by_wheel[right]])
        grown: Array = by_pose @ last.covariance @ by_pose.T + by_turn @ noise @ by_turn.T
        return grown
