"""Floor scans: what a robot sees of pieces of tape on which it drives by given velocities."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from robot.geometry import Array, Pose2, Twist2
from robot.scan import Scan

PERIOD = 1 / 15
"""Time between two pictures [s]."""
BEARINGS = np.radians(np.linspace(-45, 45, 91))
CENTRE = Pose2(0.05)
"""Where rays start, ahead of the robot."""
NOISE = 0.0005
AHEAD, LEFT, RIGHT, SPIN = Twist2(0.15), Twist2(0.15, 0.6), Twist2(0.15, -0.6), Twist2(0.0, 0.8)
FLOOR = np.array([(0.6, 0.0, 0.1), (0.9, 0.6, 0.4), (0.1, 0.7, 1.9), (-0.5, 0.2, 3.0),
                  (0.2, -0.6, -1.5), (1.2, -0.3, 0.3), (1.6, 0.4, -0.2)])  # fmt: skip
"""Places and directions of pieces of tape."""
HALF = 0.35
"""Half of a piece's length [m]."""


def ranges_from(start: Pose2) -> Array:
    """Return the ranges to pieces of tape; inf where there is none within 0.9 m."""
    heading = start.theta + BEARINGS
    rays = np.column_stack([np.cos(heading), np.sin(heading)])
    nearest = np.full(len(rays), np.inf)
    for x, y, theta in FLOOR:
        along, across = np.array([math.cos(theta), math.sin(theta)]), np.zeros(2)
        across[:] = -along[1], along[0]
        middle = np.array([x - start.x, y - start.y])
        with np.errstate(divide="ignore"):
            reach = (middle @ across) / (rays @ across)
            beside = np.abs((rays * reach[:, None] - middle) @ along)
        nearest = np.where((reach > 0.03) & (beside < HALF), np.minimum(nearest, reach), nearest)
    return np.where(nearest < 0.9, nearest, np.inf)


def drive(twists: list[Twist2], *, mirrored: bool = False) -> Iterator[tuple[Scan, Pose2]]:
    """Return the scans of a drive, and where the robot was."""
    rng, pose = np.random.default_rng(4), Pose2()
    for number, twist in enumerate(twists):
        ranges = ranges_from(pose @ CENTRE) + rng.normal(0.0, NOISE, len(BEARINGS))
        yield Scan(number * PERIOD, BEARINGS, ranges[::-1] if mirrored else ranges, CENTRE), pose
        pose = pose @ twist.integrate(PERIOD)
