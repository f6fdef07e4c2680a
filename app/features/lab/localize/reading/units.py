"""Notice wrong units: lengths in millimetres, angles in degrees; ROS has metres and radians."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from app.features.lab.localize.reading.sources import BagError
from robot.geometry import Array, Pose2

SAMPLES = 50
"""Number of scans that are looked at."""
FARTHEST_M = 300.0
"""No usual laser sees farther [m]."""
NEAREST_M = 0.05
"""Walls are farther away than this [m]."""
FASTEST = 40.0
"""A robot that usually drives faster is none [m/s]."""
SLOWEST = 0.01
"""One that drives usually drives faster [m/s]."""
USUAL_M, USUAL_SPEED = 2.0, 0.3
"""Usual distance of walls [m], and usual speed [m/s]."""
WIDEST_TURN = 1.2 * 2 * math.pi
"""A laser's rays span a turn at most, and a little [rad]."""
UNITS = {1000: "millimetres", 100: "centimetres"}
"""By how many there are in a metre."""


class UnitEvidence(NamedTuple):
    """What tells the units of one scan."""

    distance: float
    """Median range; nan without any."""
    span: float
    """From the first to the last angle."""

    @classmethod
    def of(cls, message: Any) -> UnitEvidence:
        """Look at a message."""
        ranges = np.asarray(message.ranges, dtype=np.float64)
        valid = ranges[np.isfinite(ranges) & (ranges > 0)]
        distance = float(np.median(valid)) if len(valid) else math.nan
        span = abs(float(message.angle_increment)) * max(len(ranges) - 1, 0)
        return cls(distance, span or abs(float(message.angle_max - message.angle_min)))


def require_metres(
    looks: Sequence[UnitEvidence], stamps: Array, poses: Sequence[Pose2], across: float | None
) -> None:
    """Raise BagError if all would fit in another unit.

    Args:
        looks: at some scans.
        stamps: (n,) of the poses [s].
        poses: of odometry.
        across: the diagonal of the map [m]; None if there is none.
    """
    distances = [look.distance for look in looks if not math.isnan(look.distance)]
    spans = [look.span for look in looks]
    if spans and WIDEST_TURN < (span := float(np.median(spans))) <= math.degrees(WIDEST_TURN):
        raise BagError(
            f"the angles of scans span {span:.6g}, which is {span / (2 * math.pi):.1f} turns in "
            "radians; as degrees they would fit; valid are radians (sensor_msgs/LaserScan)"
        )
    farthest = FARTHEST_M if across is None else min(FARTHEST_M, 2 * across)
    if distances and (distance := float(np.median(distances))) > farthest:
        unit = _fitting(distance, NEAREST_M, farthest, USUAL_M)
        where = "" if across is None else f", and the map is {across:.3g} m across"
        if unit:
            raise BagError(
                f"scans have ranges of about {distance:.6g} m{where}; as {unit} they would fit; "
                "valid are metres (sensor_msgs/LaserScan)"
            )
    speed = _usual_speed(stamps, poses)
    if speed > FASTEST and (unit := _fitting(speed, SLOWEST, FASTEST, USUAL_SPEED)):
        raise BagError(
            f"odometry usually drives at {speed:.6g} m/s; in {unit} it would fit; valid are metres "
            "(nav_msgs/Odometry)"
        )


def _fitting(value: float, low: float, high: float, usual: float) -> str:
    """Return the unit in which a value fits, the nearest to what is usual; empty if none does."""
    fits = [per for per in UNITS if low <= value / per <= high]
    return UNITS[min(fits, key=lambda per: abs(math.log(value / per / usual)))] if fits else ""


def _usual_speed(stamps: Array, poses: Sequence[Pose2]) -> float:
    """Return the median speed while the robot drives [m/s]."""
    places = np.array([(pose.x, pose.y) for pose in poses]).reshape(-1, 2)
    known = np.isfinite(stamps) & (np.abs(places) < 1e8).all(axis=1)
    places, stamps = places[known], stamps[known]
    driven = np.hypot(*np.diff(places, axis=0).T)
    driven, lasted = driven[driven > 0], np.diff(stamps)[driven > 0]
    return float(np.median(driven / lasted)) if len(driven) else 0.0
