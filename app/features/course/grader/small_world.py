"""A small world to try filters in: a room with beacons, and a robot that measures distances."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, compose, wrap_angle

ROOM = (0.0, 0.0, 2.0, 1.4)
"""xmin, ymin, xmax, ymax [m]."""
BEACONS = np.array([[0.0, 0.0], [2.0, 0.1], [0.3, 1.4], [1.7, 1.3]])
BEARING_SD, RANGE_SD = 0.1, 0.05
STEP = np.array([0.06, 0.0, 0.12])
STEP_SD = np.array([0.01, 0.005, 0.03])


@dataclass
class SmallWorld:
    """A robot in the room, and what a filter needs of it."""

    seed: int = 0

    def __post_init__(self) -> None:
        self.begin(self.seed)

    def begin(self, seed: int) -> None:
        """Start again, with a seed."""
        self.pose = np.array([0.6, 0.5, 0.3])
        self.rng = np.random.default_rng(seed)

    def drive(self) -> Array:
        """Move the robot by a step; return what odometry says (3,)."""
        self.pose = compose(self.pose[None], STEP + STEP_SD * self.rng.standard_normal(3))[0]
        return STEP.copy()

    def measure(self) -> Array:
        """Return distances and bearings (4, 2) of the beacons."""
        noise = self.rng.standard_normal((4, 2)) * [RANGE_SD, BEARING_SD]
        seen: Array = _seen(self.pose[None])[0] + noise
        return seen

    def motion(self, poses: Array, moved: Array) -> Array:
        """Move particles (n, 3) by a step, each with its own noise."""
        noise = 1.5 * STEP_SD * self.rng.standard_normal((len(poses), 3))
        return compose(np.asarray(poses), np.asarray(moved) + noise)

    def log_weight(self, poses: Array, scan: Array) -> Array:
        """Return the log-likelihood (n,) of distances and bearings."""
        error = _seen(np.asarray(poses)) - np.asarray(scan)
        error[..., 1] = wrap_angle(error[..., 1])
        scaled: Array = (error / [1.5 * RANGE_SD, 1.5 * BEARING_SD]) ** 2
        result: Array = -0.5 * scaled.sum(axis=(1, 2))
        return result

    def resample(self, poses: Array, weights: Array) -> tuple[Array, Array]:
        """Draw particles by weight."""
        weights = np.nan_to_num(np.asarray(weights))
        share = weights / weights.sum() if weights.sum() > 0 else np.full(len(weights), 1.0)
        drawn = self.rng.choice(len(poses), len(poses), p=share / share.sum())
        return np.asarray(poses)[drawn], np.full(len(poses), 1 / len(poses))

    def anywhere(self, count: float) -> Array:
        """Draw poses all over the room."""
        low, high = np.array([*ROOM[:2], -np.pi]), np.array([*ROOM[2:], np.pi])
        drawn: Array = self.rng.uniform(low, high, (int(count), 3))
        return drawn

    def error(self, poses: Array, weights: Array) -> float:
        """Return how far the particles' mean is from the robot [m]."""
        weights = np.nan_to_num(weights)
        if weights.sum() <= 0:
            return np.inf
        mean = weights @ poses[:, :2] / weights.sum()
        return float(np.hypot(*(mean - self.pose[:2])))


def _seen(poses: Array) -> Array:
    offset = BEACONS - poses[:, None, :2]
    bearing = np.arctan2(offset[..., 1], offset[..., 0]) - poses[:, 2:]
    return np.stack([np.hypot(offset[..., 0], offset[..., 1]), wrap_angle(bearing)], axis=-1)
