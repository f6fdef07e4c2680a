"""Position of the camera, which determines how its tilt changes scans."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.camera import FloorView
from robot.geometry import Array


@dataclass(frozen=True, slots=True)
class Mounting:
    """Position of the camera on the robot; how a tilt changes ranges depends on it."""

    x: float
    """Ahead of the robot's origin [m]."""
    height: float
    """Above the floor [m]."""

    @classmethod
    def of(cls, view: FloorView) -> Mounting:
        """Return the position of a camera above the floor."""
        x, _, height = view.robot_from_camera[:3, 3].tolist()
        return cls(x, height)

    def shifts(self, points: Array) -> Array:
        """Return how pitch and roll move floor points (n, 2) in the robot frame (n, 2, 2) [m/rad].

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
"""A laser measures ranges directly, and not by points that it sees on the floor."""
