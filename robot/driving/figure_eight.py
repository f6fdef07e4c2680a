"""The paper's figure-eight, driven open-loop: a circle to the left, a circle to the right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Twist2
from robot.settings import check_settings, setting


@dataclass(frozen=True, slots=True)
class FigureEight:
    """The figure-eight that is driven by itself: two circles that touch where the robot starts."""

    radius: float = setting(0.19, "Of both circles", unit="m", low=0.02, high=10)
    speed: float = setting(0.15, "Speed along them", unit="m/s", low=0.01, high=2)
    phase: float = setting(
        0.0, "Where a drive begins on it, as the time since its middle", unit="s", low=0, high=1e6
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def lap(self) -> float:
        """Time for both circles [s]; 15.9 s with the defaults."""
        return 4 * math.pi * self.radius / self.speed

    def path(self, points: int = 60) -> Array:
        """Return places (points, 2) on both circles [m], relative to the pose at their touch."""
        angles = np.linspace(0, 2 * math.pi, points // 2, endpoint=False)
        left = self.radius * np.column_stack([np.sin(angles), 1 - np.cos(angles)])
        return np.concatenate([left, left * (1, -1)])

    def twist(self, elapsed: float) -> Twist2:
        """Return the twist to command at a time [s] after the start; the laps repeat."""
        left = (elapsed + self.phase) % self.lap < self.lap / 2
        turning = self.speed / self.radius
        return Twist2(self.speed, turning if left else -turning)
