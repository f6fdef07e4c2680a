"""The filter's parameters. Those that nav2_amcl has too keep its names and meanings.

Defaults are for this robot on a field of a few metres, not for a building (docs/models.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.filter_kinds import FILTERS
from robot.localization.models.motion_models import MotionParameters
from robot.localization.models.sensor_models import SensorParameters
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class HypothesisParameters:
    """How places are found, weighed and given up."""

    max_hypotheses: int = setting(24, "Most places followed at once", low=1, high=100)
    scan_worth: float = setting(
        4.5,
        "How many independent rays one scan is worth when places are weighed",
        low=0.1,
        high=100,
    )
    most_a_scan: float = setting(
        3.0,
        "Most that one scan may tell for or against a place, as log-likelihood; half more for "
        "elsewhere",
        low=0.1,
        high=50,
    )
    kidnapped: float = setting(
        1e-4, "Probability that the robot is suddenly elsewhere", low=1e-9, high=0.1
    )
    hopeless: float = setting(
        6e-6, "A place that is less likely than this share of the best is given up", low=0, high=0.1
    )
    same_xy: float = setting(
        0.03, "Places nearer than this (and alike in heading) are one", unit="m", low=0.001, high=5
    )
    same_theta: float = setting(
        0.1, "Headings nearer than this are alike", unit="rad", low=0.01, high=3
    )
    map_scans: int = setting(24, "Scans in the short map", low=4, high=200)
    map_step_xy: float = setting(
        0.009, "Way between scans of the short map", unit="m", low=0.001, high=5
    )
    map_step_theta: float = setting(
        0.05, "Turn between scans of the short map", unit="rad", low=0.001, high=3
    )
    least_hits: float = setting(
        0.7, "Share of rays in the short map that must return before it is searched for",
        low=0, high=1,
    )  # fmt: skip
    search_step_xy: float = setting(
        0.04, "Step over the field in a search", unit="m", low=0.005, high=5
    )
    search_step_theta: float = setting(
        math.radians(6), "Step of the heading in a search", unit="rad", low=0.01, high=1
    )
    search_blur: float = setting(
        0.03,
        "How far the ends of rays may be from an edge in a search",
        unit="m",
        low=0.001,
        high=5,
    )
    fit_sd: float = setting(
        0.005,
        "Spread of a near range when places are fitted and weighed; it grows by sigma_slope",
        unit="m",
        low=0.001,
        high=1,
    )
    fit_gate: float = setting(
        0.08, "Ranges farther off than this are not of the edge", unit="m", low=0.005, high=10
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def log_kidnapped(self) -> float:
        """Log-probability that the robot is suddenly elsewhere."""
        return math.log(self.kidnapped)

    @property
    def log_hopeless(self) -> float:
        """Log-weight, relative to the best, below which a place is given up."""
        return math.log(max(self.hopeless, 1e-300))

    def alike(self, a: Pose2, b: Pose2) -> bool:
        """Whether two poses are so close that they count as one place."""
        return a.distance_to(b) < self.same_xy and abs(a.turn_to(b)) < self.same_theta


@dataclass(frozen=True)
class FilterParameters:
    """How the belief is kept."""

    filter: str = setting(
        "hypotheses",
        "Many particle filters that find places by themselves, one particle filter (nav2_amcl's), "
        "an extended Kalman filter; features add others, as the grid",
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
        0.1, "Spread of a pose that is set without a spread", unit="m", low=0.0001, high=100
    )
    initial_sd_theta: float = setting(
        0.3, "Spread of a heading that is set without a spread", unit="rad", low=0.0001, high=10
    )

    def __post_init__(self) -> None:
        check_settings(self)

    @property
    def initial_covariance(self) -> Array:
        """Covariance (3, 3) [m, m, rad] of a pose that is given without one."""
        return np.diag(np.square([self.initial_sd_xy, self.initial_sd_xy, self.initial_sd_theta]))

    @property
    def most_particles(self) -> int:
        """``max_particles``, but never fewer than ``min_particles``."""
        return max(self.max_particles, self.min_particles)


@dataclass(frozen=True)
class LocalizationParameters:
    """All parameters of the localization, in the groups that the dashboard shows."""

    motion: MotionParameters = MotionParameters()
    sensor: SensorParameters = SensorParameters()
    filter: FilterParameters = FilterParameters()
    hypotheses: HypothesisParameters = HypothesisParameters()
