"""Where the camera sits, which decides what its tilt does to scans."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array


@dataclass(frozen=True, slots=True)
class Mounting:
    """Where the camera is: what its tilt does to ranges depends on it."""

    x: float
    """Ahead of the robot's origin [m]."""
    height: float
    """Above the floor [m]."""

    def shifts(self, points: Array) -> Array:
        """How floor points (n, 2) in the robot frame move with pitch and roll (n, 2, 2) [m/rad].

        The first index is the point, the second x or y, the third pitch or roll.
        """
        x, y = points[:, 0] - self.x, points[:, 1]
        h = self.height
        across = x * y / h
        return np.stack(
            [
                np.column_stack([(x * x + h * h) / h, across]),
                np.column_stack([across, (y * y + h * h) / h]),
            ],
            axis=1,
        )


LASER = Mounting(0.0, math.inf)
"""A laser measures ranges; it does not see them on the floor."""
