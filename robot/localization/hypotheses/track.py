"""One hypothesis: a filter of its own, and how likely it is beside the others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numba import njit

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Filter
from robot.localization.hypothesis_parameters import HypothesisParameters
from robot.localization.kernels.matrices import inverse, solved
from robot.localization.setup import Setup

POLISH = np.diag(np.square([0.01, 0.01, 0.03]))
"""How far a hypothesis may be moved to where a scan fits, beyond its covariance [m², m², rad²]: a
camera that is mounted 0.3 degrees askew moves what it sees by so much."""
FARTHEST = 11.3
"""Squared Mahalanobis distance beyond which it would be another place: chi-square, 3, 99 %."""
FAR, STUCK = 3.0, 3
"""So many scans in a row that fit so far off, as squared Mahalanobis distance: the filter is surer
of itself than it should be, would hold on until it is lost, and is set to where they fit, if they
fit better there. Also beyond FARTHEST: of 12 robots with cameras askew two are lost if such scans
do not count."""
NARROW = 0.012
"""Of a cloud less wide than this [m] no ray can be of another edge than the nearest."""
SHARP = 0.008
"""A pose that is known better than this [m, rad] is asked for what is due there alone."""
STEADY, FORGETTING = 0.6, 0.2
"""A scan counts for so much more than the mean of those before it, as log-likelihood, and for so
much in their mean."""
INDIFFERENT = 0.5
"""Less than this, in log-likelihood, a scan does not tell for one place or another: no more than
one ray makes. Such small differences come from where a fit ends, and would add up."""

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
    _gains: tuple[float, ...] = ()
    """How much better the last scans fit where they were laid; only those in a row that lie far
    off."""
    _fitting: Pose2 | None = None
    """Where the last scan fits."""
    _mean_loss: float = 0.0
    """What a scan tells against this place, on average of the last."""

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The filter's, but for stray particles: they would make equal weights flicker."""
        hypotheses = self.filter.hypotheses
        kept = [each for each in hypotheses if each.weight > STRAY * hypotheses[0].weight]
        if len(kept) == len(hypotheses):
            return hypotheses
        all_of_it = sum(each.weight for each in hypotheses) / sum(each.weight for each in kept)
        return tuple(replace(each, weight=each.weight * all_of_it) for each in kept)

    @property
    def fits_as_well(self) -> bool:
        """Whether the last scans tell as little against this place as against the best one."""
        return self._mean_loss < INDIFFERENT

    @property
    def best(self) -> Hypothesis:
        """Where it says the robot is."""
        return self.filter.hypotheses[0]

    @property
    def pose(self) -> Pose2:
        """Where it says the robot is."""
        return self.best.pose

    def fit(self, rays: Array, setup: Setup) -> float:
        """How well rays fit here, once they are laid on the edges.

        So that the filter's luck in finding its mean does not count: of places that look the same,
        none comes to seem likelier than another.
        """
        best = self.best
        known = inverse(best.covariance + POLISH)
        narrow = float(np.trace(best.covariance[:2, :2])) < NARROW**2
        matcher = setup.fine_matcher if narrow else setup.matcher
        match = matcher.match(best.pose, rays, known)
        fitting = match.pose
        away = best.pose.offset_to(fitting)
        far = float(away @ known @ away)
        # (C^-1 + S)^-1 of the covariance and what the scan says, also where either is singular.
        seen = match.information - known
        left = solved(np.eye(3) + best.covariance @ seen, best.covariance)
        poses = np.concatenate([best.pose.to_array()[None], _around(fitting.to_array(), left)])
        logs = setup.evidence.log_likelihoods(poses, rays)
        current, target = float(logs[0]), float(logs[1:].max())
        self._fitting = fitting
        self._gains = (*self._gains, target - current)[-STUCK:] if far > FAR else ()
        # Farther than it may be, it would live on what fits another place.
        return target if far < FARTHEST else current

    def fit_unlaid(self, rays: Array, setup: Setup) -> float:
        """How well rays fit as the filter has it.

        Laid on the edges, a wrong place would fit too well to be noticed.
        """
        poses = _around(self.pose.to_array(), self.best.covariance)
        return float(setup.evidence.log_likelihoods(poses, rays).max())

    def lose(self, loss: float, most: float) -> None:
        """Take off what a scan tells against this place, and for the best one.

        Successive scans err together: one piece of tape that is seen badly is seen so for a dozen
        pictures. So a scan counts for little more than the mean of those before it, and a steady
        difference in full after some scans.
        """
        counted = min(loss, self._mean_loss + STEADY, most)
        self._mean_loss += FORGETTING * (min(loss, most) - self._mean_loss)
        self.log_weight -= counted if counted > INDIFFERENT else 0.0

    def come_unstuck(self) -> bool:
        """Begin anew where scans fit, if they have fitted far off, and better, for long enough.

        Returns whether it did.
        """
        better = len(self._gains) == STUCK and self._gains[-1] > 0 and sum(self._gains) > 0
        if better and self._fitting is not None:
            self.filter.set_pose(self._fitting, self.best.covariance + POLISH)
            self._gains = ()
            return True
        return False


def distinct(tracks: Sequence[Track], parameters: HypothesisParameters) -> list[Track]:
    """The heaviest first, without those that are hopeless, or where a heavier one is."""
    kept: list[Track] = []
    for track in sorted(tracks, key=lambda track: -track.log_weight):
        hopeless = kept and track.log_weight < kept[0].log_weight + parameters.log_hopeless
        if not hopeless and not any(parameters.alike(track.pose, other.pose) for other in kept):
            kept.append(track)
    return kept[: parameters.max_hypotheses]


@njit(cache=True, nogil=True)
def _around(pose: Array, covariance: Array) -> Array:
    """A pose and those a standard deviation beside it (7, 3); it alone if it is known sharply.

    Of a robot that turns and sees nothing the heading is known less and less: that an edge is
    missed which is due at the mean, and not beside it, tells nothing.
    """
    poses = np.empty((7, 3))
    poses[:] = pose
    if not np.trace(covariance) > SHARP**2:
        return poses[:1]
    squares, axes = np.linalg.eigh(0.5 * (covariance + covariance.T))
    if not squares[-1] > SHARP**2:
        return poses[:1]
    for i in range(3):
        beside = axes[:, i] * math.sqrt(max(squares[i], 0.0))
        poses[1 + i] += beside
        poses[4 + i] -= beside
    return poses
