"""One hypothesis: a filter of its own, and how likely it is beside the others."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Filter
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher

POLISH = np.diag(np.square([0.005, 0.005, 0.02]))
"""How far a hypothesis may be moved to where a scan fits, beyond its covariance [m², m², rad²]."""


class TrackFilter(Filter, Protocol):
    """A filter that can be one of many."""

    share: float
    """Part of its usual number of particles that it may keep."""


@dataclass
class Track:
    """A hypothesis that lives."""

    filter: TrackFilter
    log_weight: float
    """Relative to the heaviest."""

    @property
    def best(self) -> Hypothesis:
        """Where it says the robot is."""
        return self.filter.hypotheses[0]

    @property
    def pose(self) -> Pose2:
        """Where it says the robot is."""
        return self.best.pose

    def fit(self, rays: Array, matcher: ScanMatcher, evidence: RayEvidence) -> float:
        """How well rays fit here, once they are laid on the edges.

        So that the filter's luck in finding its mean does not count: of places that look the same,
        none comes to seem likelier than another.
        """
        best = self.best
        known = np.linalg.inv(best.covariance + POLISH)
        return evidence.log_likelihood(matcher.match(best.pose, rays, known).pose, rays)
