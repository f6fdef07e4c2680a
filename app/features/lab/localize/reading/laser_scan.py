"""Convert a sensor_msgs/LaserScan to a scan in the plane of the robot."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.features.lab.localize.reading.sources import BagError
from app.features.lab.localize.reading.transforms import Rigid3
from robot.geometry import Array, Pose2
from robot.scan import Scan

STEEPEST = math.radians(30)
"""Largest tilt: a laser that looks farther up or down does not see the map's walls."""

LARGEST_ANGLE = 100.0
"""Angles beyond this [rad], 16 turns, cannot come from a laser."""


class ScanReader:
    """Makes scans from the messages of one laser."""

    def __init__(self, base_from_laser: Rigid3) -> None:
        """Prepare for a mounting, which may be turned, tilted a little or upside down.

        Raises:
            BagError: the laser is tilted by more than 30 degrees.
        """
        tilt = math.acos(min(abs(float(base_from_laser.rotation[2, 2])), 1.0))
        if tilt > STEEPEST:
            raise BagError(
                f"the laser is tilted by {math.degrees(tilt):.0f} degrees; valid is up to "
                f"{math.degrees(STEEPEST):.0f}, or --laser-pose says how it is mounted"
            )
        self._rotation = base_from_laser.rotation
        x, y, _ = base_from_laser.translation
        self._place = Pose2(float(x), float(y), 0.0)
        self._form: tuple[float, float, int] | None = None
        self._bearings: Array = np.zeros(0)
        self._shares: Array = np.zeros(0)

    def scan(self, message: Any, stamp: float) -> Scan | None:
        """Return the scan in the base's plane; None if its angles or ranges are unusable.

        By REP-117 a range is valid if it is finite and within range_min and range_max. All else
        (nan, +-inf, 0, and range_max itself) counts as no return.
        """
        ranges = np.asarray(message.ranges, dtype=np.float64)
        form = (message.angle_min, _increment(message, len(ranges)), len(ranges))
        reach = abs(form[0]) + abs(form[1]) * len(ranges)
        if not (len(ranges) and reach < LARGEST_ANGLE):  # nan fails, too
            return None
        if form != self._form:
            self._look_along(*form)
            self._form = form
        valid = _returned(ranges, message.range_min, message.range_max)
        return Scan(
            stamp, self._bearings, np.where(valid, ranges * self._shares, np.inf), self._place
        )

    def _look_along(self, first: float, step: float, count: int) -> None:
        """Set the bearings in the base's plane, and the share of a ray's length that lies in it."""
        angles = first + step * np.arange(count)
        along = np.stack([np.cos(angles), np.sin(angles), np.zeros(count)])
        x, y, _ = self._rotation @ along
        self._bearings, self._shares = np.arctan2(y, x), np.hypot(x, y)


def _increment(message: Any, count: int) -> float:
    """Return the angle between rays; if the driver left it out, by the first and last angle."""
    if message.angle_increment or count < 2:
        return float(message.angle_increment)
    return float(message.angle_max - message.angle_min) / (count - 1) or math.nan


def _returned(ranges: Array, low: float, high: float) -> NDArray[np.bool_]:
    least = low if math.isfinite(low) and low > 0 else 0.0
    most = high if math.isfinite(high) and high > least else math.inf
    return (ranges >= least) & (ranges > 0) & (ranges < most)  # nan fails all comparisons
