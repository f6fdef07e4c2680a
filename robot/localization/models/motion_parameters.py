"""How odometry errs: nav2_amcl's parameters under its names, and those of the book's others."""

from __future__ import annotations

from dataclasses import dataclass

from robot.localization.models.motion_models import (
    DifferentialMotion,
    MotionModel,
    OmniMotion,
    StationaryMotion,
    VelocityMotion,
)
from robot.settings import check_settings, setting

MOTION_MODELS = ("differential", "omni", "velocity", "stationary")


@dataclass(frozen=True)
class MotionParameters:
    """How odometry errs."""

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
        """The chosen model with these parameters."""
        match self.robot_model_type:
            case "differential":
                return DifferentialMotion(self.alpha1, self.alpha2, self.alpha3, self.alpha4)
            case "omni":
                return OmniMotion(self.alpha1, self.alpha2, self.alpha3, self.alpha4, self.alpha5)
            case "velocity":
                return VelocityMotion(
                    self.velocity_alpha1,
                    self.velocity_alpha2,
                    self.velocity_alpha3,
                    self.velocity_alpha4,
                    self.velocity_alpha5,
                    self.velocity_alpha6,
                )
            case "stationary":
                return StationaryMotion(self.stationary_sd_xy, self.stationary_sd_theta)
        raise NotImplementedError(f"{self.robot_model_type} is listed, but has no case here")
