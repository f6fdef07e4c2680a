"""A motion model whose steps err more than it says: while wheels slip."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2, compose, wrap_angle
from robot.localization.models.motion_models import MotionModel


@dataclass(frozen=True, slots=True)
class LoosenedMotion:
    """Another model, with all its standard deviations so many times wider."""

    model: MotionModel
    factor: float

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw where each particle (n, 3) went."""
        drawn = self.model.sample(poses, moved, rng)
        mean = compose(poses, self.model.moments(moved)[0].to_array())
        away = drawn - mean
        away[:, 2] = wrap_angle(away[:, 2])
        loosened: Array = mean + self.factor * away
        loosened[:, 2] = wrap_angle(loosened[:, 2])
        return loosened

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Mean and covariance (3, 3) of where a step ends."""
        mean, covariance = self.model.moments(moved)
        return mean, covariance * self.factor**2


def loosened(model: MotionModel, factor: float) -> MotionModel:
    """The model itself, if steps err as usual."""
    return model if factor == 1.0 else LoosenedMotion(model, factor)
