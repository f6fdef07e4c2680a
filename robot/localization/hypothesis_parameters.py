"""Parameters of the multi-hypothesis filter."""

from __future__ import annotations

import math
from dataclasses import dataclass

from robot.geometry import Pose2
from robot.settings import check_settings, setting


@dataclass(frozen=True)
class HypothesisParameters:
    """How places are found, weighed and given up."""

    max_hypotheses: int = setting(24, "Most places followed at once", low=1, high=100)
    scan_worth: float = setting(
        4.5, "So many independent rays is one scan worth when places are weighed", low=0.1, high=100
    )
    most_a_scan: float = setting(
        3.0,
        "Most that one scan may tell for or against a place, as log-likelihood",
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
        0.03, "How far ends of rays may lie off in a search", unit="m", low=0.001, high=5
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
