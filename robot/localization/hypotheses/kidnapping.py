"""The probability of a kidnapping: that the robot is at none of the followed places."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Array
from robot.localization.parameters import HypothesisParameters
from robot.localization.ray_evidence import RayEvidence

FRESH = -2.5
"""Log-weight of being elsewhere when places are found for the first time. Half: false alarms
in 1.8 % of pictures instead of 0.2; twice: 5 of 30 places not found instead of 3, by chance 4."""

SUSPECTED = 2 / 3
"""A kidnapping is suspected if its log-weight rises above this share of ``log_kidnapped``. With 1/3
and 1 nothing changes beyond chance."""


class Kidnapping:
    """Log-weight of being elsewhere; it grows while no hypothesis fits.

    It does not fall below the probability that the robot was carried off just now.
    """

    def __init__(self, log_weight: float) -> None:
        self.log_weight = log_weight
        """Relative to the heaviest hypothesis."""
        self.lost = False
        """Whether elsewhere is likelier than the heaviest hypothesis."""
        self.suspected = False
        """Whether elsewhere is likelier than usual."""
        self.doubts = 0
        """Number of successive scans that fit no place."""

    def weigh(
        self, best: float, rays: Array, evidence: RayEvidence, p: HypothesisParameters
    ) -> None:
        """Compare how well rays (n, 9) fit the best hypothesis with a place that fits badly."""
        anywhere = evidence.background_log_likelihood(rays)
        gain = p.scan_worth * (anywhere - best)
        self.log_weight += min(max(gain, -p.most_a_scan), 1.5 * p.most_a_scan)
        self.doubts = self.doubts + 1 if gain > 0 else 0

    def level(self, heaviest: float, p: HypothesisParameters) -> bool:
        """Scale the heaviest weight to one; return whether the robot has just become lost."""
        least, before = p.log_kidnapped, self.lost
        self.suspected = self.log_weight - heaviest > SUSPECTED * least
        self.log_weight = min(max(self.log_weight - heaviest, least), -least)
        self.lost = self.log_weight > 0
        return self.lost and not before

    def beside(self, log_weights: list[float]) -> Array:
        """Return the weights (n,) of places; with that of being elsewhere, they sum to one."""
        likelihood = np.exp(log_weights)
        weights: Array = likelihood / (likelihood.sum() + math.exp(self.log_weight))
        return weights

    def at_least(self, log_weight: float) -> None:
        """Raise the log-weight to at least this value."""
        self.log_weight = max(self.log_weight, log_weight)
