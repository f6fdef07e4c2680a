"""Motion models: where a robot may be after a step by odometry; and their parameters.

A motion model is a frozen dataclass with ``sample`` and ``moments``; a student's own model is used
in the same way. The parameters have nav2_amcl's names; the book's other models add more.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2, compose, mean_pose, pose_covariance, wrap_angle
from robot.localization.models.odometry_motion import (
    STANDING_M,
    DifferentialMotion,
    OmniMotion,
    StationaryMotion,
)
from robot.settings import check_settings, setting

__all__ = [
    "STANDING_M",
    "DifferentialMotion",
    "MotionModel",
    "OmniMotion",
    "StationaryMotion",
    "sampled_moments",
]
Sample = Callable[[Array, Pose2, np.random.Generator], Array]
_ALPHAS = ("alpha1", "alpha2", "alpha3", "alpha4")
_VELOCITY_ALPHAS = tuple(f"velocity_alpha{number}" for number in range(1, 7))
MODELS = {
    "differential": ("odometry_motion:DifferentialMotion", _ALPHAS),
    "omni": ("odometry_motion:OmniMotion", (*_ALPHAS, "alpha5")),
    "velocity": ("velocity_motion:VelocityMotion", _VELOCITY_ALPHAS),
    "stationary": ("odometry_motion:StationaryMotion", ("stationary_sd_xy", "stationary_sd_theta")),
}
"""Class of each model, imported at its first use, and the settings for its fields, in order."""
MOTION_MODELS = tuple(MODELS)


class MotionModel(Protocol):
    """The interface of a motion model."""

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw the pose of each particle after a step.

        Args:
            poses: (n, 3) particles [m, m, rad].
            moved: the step by odometry, seen from its start.
            rng: the only source of chance.

        Returns:
            (n, 3) particles after the step.
        """
        ...

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Return mean and covariance (3, 3) [m, m, rad] of a step's end, seen from its start.

        Filters without particles need them. They are the moments of ``sample`` to first order, in
        closed form; a user's own model without a closed form gets ``sampled_moments``.

        Args:
            moved: the step by odometry, seen from its start.
        """
        ...


def sampled_moments(sample: Sample, moved: Pose2, count: int = 1000) -> tuple[Pose2, Array]:
    """Return mean and covariance (3, 3) [m, m, rad] of a step's end, seen from its start, by draws.

    The draws are always the same, so a step always has the same covariance.
    """
    ends = sample(np.zeros((count, 3)), moved, np.random.default_rng(0))
    even = np.full(count, 1.0 / count)
    mean = mean_pose(ends, even)
    return mean, pose_covariance(ends, even, mean)


@dataclass(frozen=True, slots=True)
class LoosenedMotion:
    """A model with the standard deviations of another, multiplied by a factor."""

    model: MotionModel
    factor: float

    def sample(self, poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        """Draw the pose of each particle (n, 3) after a step."""
        drawn = self.model.sample(poses, moved, rng)
        mean = compose(poses, self.model.moments(moved)[0].to_array())
        away = drawn - mean
        away[:, 2] = wrap_angle(away[:, 2])
        loosened: Array = mean + self.factor * away
        loosened[:, 2] = wrap_angle(loosened[:, 2])
        return loosened

    def moments(self, moved: Pose2) -> tuple[Pose2, Array]:
        """Return mean and covariance (3, 3) of a step's end."""
        mean, covariance = self.model.moments(moved)
        return mean, covariance * self.factor**2


def loosened(model: MotionModel, factor: float) -> MotionModel:
    """Return the model with its standard deviations multiplied by a factor."""
    return model if factor == 1.0 else LoosenedMotion(model, factor)


@dataclass(frozen=True)
class MotionParameters:
    """Parameters of the motion models: how odometry errs."""

    robot_model_type: str = setting(
        "differential", "How a step by odometry spreads the cloud", choices=MOTION_MODELS
    )
    alpha1: float = setting(
        0.04, "Variance of a turn, by turn squared", unit="rad²/rad²", low=0, high=10
    )
    alpha2: float = setting(
        0.5, "Variance of a turn, by distance squared", unit="rad²/m²", low=0, high=1000
    )
    alpha3: float = setting(
        0.04, "Variance of a distance, by distance squared", unit="m²/m²", low=0, high=10
    )
    alpha4: float = setting(
        0.0004, "Variance of a distance, by turn squared", unit="m²/rad²", low=0, high=10
    )
    alpha5: float = setting(
        0.04, "Variance across the way, by distance squared (omni)", unit="m²/m²", low=0, high=10
    )
    velocity_alpha1: float = setting(
        0.04, "Variance of v, by v squared (velocity)", unit="m²/m²", low=0, high=10
    )
    velocity_alpha2: float = setting(
        0.0004, "Variance of v, by omega squared (velocity)", unit="m²/rad²", low=0, high=1
    )
    velocity_alpha3: float = setting(
        0.5, "Variance of omega, by v squared (velocity)", unit="rad²/m²", low=0, high=1000
    )
    velocity_alpha4: float = setting(
        0.04, "Variance of omega, by omega squared (velocity)", unit="rad²/rad²", low=0, high=10
    )
    velocity_alpha5: float = setting(
        0.05, "Variance of the final rotation, by v squared (velocity)",
        unit="rad²/m²", low=0, high=1000,
    )  # fmt: skip
    velocity_alpha6: float = setting(
        0.004, "Variance of the final rotation, by omega squared (velocity)",
        unit="rad²/rad²", low=0, high=10,
    )  # fmt: skip
    stationary_sd_xy: float = setting(
        0.01, "Spread of the place in a step (stationary)", unit="m", low=0, high=1
    )
    stationary_sd_theta: float = setting(
        0.1, "Spread of the heading in a step (stationary)", unit="rad", low=0, high=3.2
    )

    def __post_init__(self) -> None:
        check_settings(self)

    def model(self) -> MotionModel:
        """Return the chosen model with these parameters."""
        place, settings = MODELS[self.robot_model_type]
        model = resolve_name(f"{__package__}.{place}")
        made: MotionModel = model(*(getattr(self, name) for name in settings))
        return made


def follow(pose: Pose2, covariance: Array, moved: Pose2, noise: Array) -> tuple[Pose2, Array]:
    """Carry a pose with its covariance over a step: G Sigma G^T + V M V^T.

    Args:
        covariance: Sigma (3, 3), the pose's covariance [m, m, rad].
        moved: the step, seen from its start.
        noise: M (3, 3), the covariance of the step's end, seen from its start.
    """
    turned = Pose2(theta=pose.theta).apply(moved.to_array()[None, :2])[0]
    G = np.array([[1, 0, -turned[1]], [0, 1, turned[0]], [0, 0, 1]])
    c, s = np.cos(pose.theta), np.sin(pose.theta)
    V = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    moved_covariance = G @ covariance @ G.T + V @ noise @ V.T
    return pose @ moved, (moved_covariance + moved_covariance.T) / 2
