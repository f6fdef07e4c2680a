"""A simulated laser robot that wanders through a ROS map, for tests and benchmarks."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.reading.pairing import Measurement
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, Twist2
from robot.scan import Scan

HZ = 10.0
FASTEST, TURNING = 0.6, 1.2
"""[m/s], [rad/s]"""
ROOM = 0.35
"""Distance that the robot keeps from walls, if it can [m]."""


@dataclass(frozen=True)
class Laser:
    """A laser, its errors, and the errors of the wheels."""

    beams: int = 360
    view: float = 2 * math.pi
    """[rad]"""
    reach: float = 30.0
    """[m]"""
    sd: float = 0.02
    """Standard deviation of a range [m]."""
    missing: float = 0.02
    """Share of rays that return nothing."""
    short: float = 0.05
    """Share of rays that end at an object that is not on the map."""
    wheels: float = 0.1
    """Standard deviation of odometry's errors, as a share of each step's distance and turn."""
    drift: float = 0.02
    """Additional systematic turn of odometry per metre [rad/m]."""
    place: Pose2 = field(default=Pose2(0.1, 0.0, 0.0))
    """Pose of the laser on the robot."""

    @property
    def step(self) -> float:
        """Angle between rays [rad]; on a full turn the last ray does not repeat the first."""
        whole = self.view > 2 * math.pi - 1e-6
        return self.view / (self.beams if whole else self.beams - 1)

    @property
    def bearings(self) -> Array:
        """(beams,) [rad]"""
        return np.asarray(-self.view / 2 + self.step * np.arange(self.beams), dtype=np.float64)


class Seen(NamedTuple):
    """Truth, odometry and ranges at one moment."""

    stamp: float
    truth: Pose2
    """The true pose in the frame of the map's cells."""
    odometry: Pose2
    ranges: Array
    """(beams,) [m]; +inf where nothing returned."""


def wander(
    laser_map: LaserMap, laser: Laser, seconds: float, seed: int, start: Pose2
) -> Iterator[Seen]:
    """Drive where there is room, for a time [s], from a start in the frame of the cells."""
    rng = np.random.default_rng(seed)
    truth, odometry = start, Pose2()
    bearings, exact = laser.bearings, np.empty((1, laser.beams))
    for tick in range(round(seconds * HZ)):
        sensor = truth @ laser.place
        cast_rays(sensor.to_array()[None], bearings, laser_map.field.edge_index, laser.reach, exact)
        yield Seen(tick / HZ, truth, odometry, _measured(exact[0], laser, rng))
        twist = _steered(exact[0], bearings)
        truth = truth @ twist.integrate(1 / HZ)
        odometry = odometry @ _counted(twist, laser, rng)


def measurements(seen: Iterator[Seen], laser: Laser) -> Iterator[Measurement]:
    """Yield the measurements for a filter: odometry and scan."""
    for moment in seen:
        scan = Scan(moment.stamp, laser.bearings, moment.ranges, laser.place)
        yield Measurement(moment.odometry, scan)


def _measured(exact: Array, laser: Laser, rng: np.random.Generator) -> Array:
    ranges = exact + rng.normal(0, laser.sd, len(exact))
    # People and bags: neighbouring rays end at the same object.
    hidden = np.repeat(rng.random(len(exact) // 10 + 1) < laser.short, 10)[: len(exact)]
    near = np.repeat(rng.random(len(exact) // 10 + 1), 10)[: len(exact)]
    ranges = np.where(hidden & np.isfinite(exact), ranges * near, ranges)
    ranges[rng.random(len(exact)) < laser.missing] = np.inf
    return np.where(ranges > 0.05, ranges, np.inf)


def _steered(ranges: Array, bearings: Array) -> Twist2:
    """Steer toward the widest gap ahead; drive slower if there is little room."""
    ahead = np.abs(bearings) < math.radians(100)
    seen, toward = np.minimum(ranges[ahead], 6.0), bearings[ahead]
    width = max(1, round(math.radians(30) / abs(bearings[1] - bearings[0])))
    padded = np.pad(seen, (width // 2, width - 1 - width // 2), mode="edge")
    gaps = np.lib.stride_tricks.sliding_window_view(padded, width).min(axis=1)
    best = toward[int(np.argmax(gaps - 0.3 * np.abs(toward)))]
    front = float(ranges[np.abs(bearings) < math.radians(20)].min())
    speed = FASTEST * float(np.clip((front - ROOM) / 1.0, 0.0, 1.0))
    return Twist2(speed, float(np.clip(1.5 * best, -TURNING, TURNING)))


def _counted(twist: Twist2, laser: Laser, rng: np.random.Generator) -> Pose2:
    """Return the step by odometry, with its errors."""
    wrong_v, wrong_omega = 1 + rng.normal(0, laser.wheels, 2)
    drift = laser.drift * abs(twist.v)
    return Twist2(twist.v * wrong_v, twist.omega * wrong_omega + drift).integrate(1 / HZ)
