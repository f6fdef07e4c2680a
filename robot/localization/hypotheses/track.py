"""One hypothesis: a filter of its own, and how likely it is beside the others."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Filter
from robot.localization.ray_evidence import RayEvidence
from robot.localization.scan_matching import ScanMatcher

POLISH = np.diag(np.square([0.01, 0.01, 0.03]))
"""How far a hypothesis may be moved to where a scan fits, beyond its covariance [m², m², rad²]: a
camera that is mounted 0.3 degrees askew moves what it sees by so much."""
FARTHEST = 11.3
"""Squared Mahalanobis distance beyond which it would be another place: chi-square, 3, 99 %."""
FAR, STUCK = 3.0, 3
"""So many scans in a row that fit so far off, as squared Mahalanobis distance: the filter is surer
of itself than it should be, would hold on until it is lost, and is set to where they fit. Also
beyond FARTHEST: of 12 robots with cameras askew two are lost if such scans do not count."""

STRAY = 0.05
"""Clusters below this share of a track's heaviest are no places of their own."""


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
    born: int = 0
    """Scans that had been kept when it was found."""
    strayed: int = 0
    """Scans in a row that fit far off."""
    fitting: Pose2 | None = None
    """Where the last scan fits."""

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The filter's, but for stray particles: they would make equal weights flicker."""
        found = self.filter.hypotheses
        kept = [one for one in found if one.weight > STRAY * found[0].weight]
        all_of_it = sum(one.weight for one in found) / sum(one.weight for one in kept)
        return tuple(replace(one, weight=one.weight * all_of_it) for one in kept)

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
        fitting = matcher.match(best.pose, rays, known).pose
        away = best.pose.offset_to(fitting)
        far = float(away @ known @ away)
        self.fitting = fitting
        self.strayed = self.strayed + 1 if far > FAR else 0
        # Farther than it may be, it would live on what fits another place.
        return evidence.log_likelihood(fitting if far < FARTHEST else best.pose, rays)

    def come_unstuck(self) -> None:
        """Begin anew where scans fit, if they have fitted far off for long enough."""
        if self.strayed >= STUCK and self.fitting is not None:
            self.filter.set_pose(self.fitting, self.best.covariance + POLISH)
            self.strayed = 0
