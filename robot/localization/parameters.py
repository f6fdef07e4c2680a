"""The filter's parameters: what nav2_amcl has too is under its names and with their meanings.

Defaults are for this robot on a field of a few metres, not for a building (docs/models.md).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robot.geometry import Array
from robot.localization.hypotheses.hypothesis_parameters import HypothesisParameters
from robot.localization.models.motion_models import (
    DifferentialMotion,
    MotionModel,
    OmniMotion,
    StationaryMotion,
    VelocityMotion,
)
from robot.settings import check_settings, setting

MOTION_MODELS = ("differential", "omni", "velocity", "stationary")
FILTERS = ("hypotheses", "particles", "kalman", "grid")
SENSOR_MODELS = ("likelihood_field", "likelihood_field_prob", "beam")


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
        return DifferentialMotion(self.alpha1, self.alpha2, self.alpha3, self.alpha4)


@dataclass(frozen=True)
class SensorParameters:
    """How the scan errs."""

    laser_model_type: str = setting(
        "likelihood_field", "How well a scan fits a pose", choices=SENSOR_MODELS
    )
    sigma_hit: float = setting(
        0.003, "Spread of a range that hit an edge of the map", unit="m", low=0.0005, high=0.5
    )
    sigma_slope: float = setting(
        8.0,
        "How that grows with a range r, as 1 + slope r²: the farther the floor, the more of it a "
        "pixel sees, and the more a camera askew misplaces it (likelihood fields); 0 is a laser's",
        unit="1/m²",
        low=0,
        high=100,
    )
    z_hit: float = setting(0.95, "Share of ranges that hit an edge of the map", low=0, high=1)
    z_rand: float = setting(0.05, "Share of ranges that are false", low=0.001, high=1)
    z_short: float = setting(
        0.05, "Share of ranges cut short by something not in the map (beam)", low=0, high=1
    )
    z_max: float = setting(
        0.05, "Share of rays that miss an edge they should have met (beam)", low=0.001, high=1
    )
    lambda_short: float = setting(
        5.0,
        "How quickly short ranges become rare with distance (beam)",
        unit="1/m",
        low=0.01,
        high=100,
    )
    max_beams: int = setting(60, "Rays used of each scan", low=3, high=720)
    do_beamskip: bool = setting(
        False, "Skip rays that hardly any particle can explain (likelihood_field_prob)"
    )
    beam_skip_distance: float = setting(
        0.02, "A ray that ends closer to an edge agrees with a particle", unit="m",
        low=0.001, high=2,
    )  # fmt: skip
    beam_skip_threshold: float = setting(
        0.3, "Rays that agree with no greater share of the particles are skipped", low=0, high=1
    )
    beam_skip_error_threshold: float = setting(
        0.9, "If this share of the rays would be skipped, none is", low=0, high=1
    )
    likelihood_weight: float = setting(
        0.2,
        "Share of each ray's log-likelihood that counts, as neighbouring rays err together",
        low=0.001,
        high=1,
    )
    laser_min_range: float = setting(0.0, "Nearer returns are left out", unit="m", low=0, high=100)
    laser_max_range: float = setting(
        1.0, "Longest range; farther returns count as none", unit="m", low=0.05, high=100
    )
    laser_likelihood_max_dist: float = setting(
        0.15, "Ends farther from an edge than this count alike", unit="m", low=0.01, high=2
    )
    field_resolution: float = setting(
        0.005, "Cell of the table of distances", unit="m", low=0.002, high=0.5
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True)
class FilterParameters:
    """How the belief is kept."""

    filter: str = setting(
        "hypotheses",
        "Many particle filters that find places by themselves, one particle filter (nav2_amcl's), "
        "an extended Kalman filter, or a grid",
        choices=FILTERS,
    )
    refine: bool = setting(
        True, "Lay the scan on the edges at the estimate, for a finer one (Gauss-Newton)"
    )
    min_particles: int = setting(500, "Fewest particles", low=10, high=20_000)
    max_particles: int = setting(
        4000, "Most particles; no fewer than the fewest", low=10, high=20_000
    )
    pf_err: float = setting(
        0.05, "Greatest distance between the true and the sampled distribution", low=0.001, high=1
    )
    pf_z: float = setting(0.99, "Standard normal quantile for staying below pf_err", low=0, high=5)
    update_min_d: float = setting(
        0.002, "Travel before the next measurement counts", unit="m", low=0, high=10
    )
    update_min_a: float = setting(
        0.005, "Turn before the next measurement counts", unit="rad", low=0, high=6.3
    )
    recovery_alpha_slow: float = setting(
        0.0, "Decay of the slow average of how scans fit; 0 never tries elsewhere", low=0, high=1
    )
    recovery_alpha_fast: float = setting(
        0.0, "The same of the fast average, whose fall brings in random poses", low=0, high=1
    )
    resample_interval: int = setting(1, "Measurements between resamplings", low=1, high=100)
    selective_resampling: bool = setting(
        False,
        "Resample only when fewer than half of the particles are effective (ROS 1's amcl; "
        "nav2_amcl has no such parameter)",
    )
    min_effective: float = setting(
        0.05,
        "Share of the particles that stays effective between two resamplings; measurements count "
        "less if not",
        low=0,
        high=0.9,
    )
    regularization: float = setting(
        1.0, "How far copies of a particle are spread, by the cluster's own spread", low=0, high=2
    )
    cell_xy: float = setting(
        0.05, "Cell in which particles are alike, for counting and clusters", unit="m",
        low=0.001, high=10,
    )  # fmt: skip
    cell_theta: float = setting(
        0.175, "Cell in which headings are alike", unit="rad", low=0.01, high=3.2
    )
    initial_sd_xy: float = setting(
        0.1, "Spread of a pose told without one", unit="m", low=0.0001, high=100
    )
    initial_sd_theta: float = setting(
        0.3, "Spread of a heading told without one", unit="rad", low=0.0001, high=10
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def initial_covariance(self) -> Array:
        """Covariance (3, 3) [m, m, rad] of a pose told without one."""
        return np.diag(np.square([self.initial_sd_xy, self.initial_sd_xy, self.initial_sd_theta]))

    @property
    def most_particles(self) -> int:
        """``max_particles``, but never fewer than ``min_particles``."""
        return max(self.max_particles, self.min_particles)


@dataclass(frozen=True)
class LocalizationParameters:
    """All of them, in the groups that the dashboard shows."""

    motion: MotionParameters = MotionParameters()
    sensor: SensorParameters = SensorParameters()
    filter: FilterParameters = FilterParameters()
    hypotheses: HypothesisParameters = HypothesisParameters()
