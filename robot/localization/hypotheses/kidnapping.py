"""The chance that the robot is at none of the places that are followed."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Array
from robot.localization.hypothesis_parameters import HypothesisParameters
from robot.localization.ray_evidence import RayEvidence

FRESH = -2.5
"""Log-weight of being elsewhere when places were found for the first time."""

SUSPECTED = 2 / 3
"""Part of the log-probability of having been carried that is left where that is suspected."""


class Kidnapping:
    """Grows while no hypothesis fits, down to the chance of having been carried off just now."""

    def __init__(self, log_weight: float) -> None:
        self.log_weight = log_weight
        """Relative to the heaviest hypothesis."""
        self.lost = False
        """Whether it is the likeliest."""
        self.suspected = False
        """Whether it has become likelier than usual."""
        self.doubts = 0
        """Scans in a row that fit no place."""

    def weigh(
        self, best: float, rays: Array, evidence: RayEvidence, p: HypothesisParameters
    ) -> None:
        """Compare how well rays (n, 7) fit where they fit best with a place that fits but badly."""
        anywhere = evidence.log_likelihood_anywhere(rays)
        gain = p.scan_worth * (anywhere - best)
        self.log_weight += min(max(gain, -p.most_a_scan), 1.5 * p.most_a_scan)
        self.doubts = self.doubts + 1 if gain > 0 else 0

    def level(self, heaviest: float, p: HypothesisParameters) -> bool:
        """Make the heaviest hypothesis weigh one; returns whether the robot is lost only now."""
        least, before = p.log_kidnapped, self.lost
        self.suspected = self.log_weight - heaviest > SUSPECTED * least
        self.log_weight = min(max(self.log_weight - heaviest, least), -least)
        self.lost = self.log_weight > 0
        return self.lost and not before

    def beside(self, log_weights: list[float]) -> Array:
        """Weights (n,) of places, which sum to less than one by what is elsewhere."""
        likelihood = np.exp(log_weights)
        weights: Array = likelihood / (likelihood.sum() + math.exp(self.log_weight))
        return weights

    def at_least(self, log_weight: float) -> None:
        """Take it for no less likely than that."""
        self.log_weight = max(self.log_weight, log_weight)
