"""Track: one hypothesis with its own filter, and its weight relative to the others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from robot.compiling import compiled
from robot.covariance import inverse, solved
from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Filter, Setup
from robot.localization.parameters import HypothesisParameters
from robot.localization.ray_evidence import RayEvidence, ray_log_likelihoods
from robot.localization.scan_matching import ScanMatcher, fit_rays

MATCH_COVARIANCE = np.diag(np.square([0.01, 0.01, 0.03]))
"""Covariance added to a hypothesis's own when it is moved to where a scan fits [m², m², rad²]: a
camera that is mounted 0.3 degrees askew shifts what it sees by this much."""
FARTHEST = 11.3
"""Squared Mahalanobis distance beyond which a pose is another place (chi-square, 3, 99 %)."""
FAR, STUCK = 3.0, 3
"""If STUCK successive scans fit farther off than FAR (squared Mahalanobis distance), the filter is
overconfident, and would stay where it is until it is lost. So it is restarted where they fit, if
they fit better there. Scans beyond FARTHEST count too: without them, two of 12 robots with askew
cameras get lost. Half and twice of FAR: nothing changes beyond chance (``--few``)."""
NARROW = 0.012
"""In a cloud narrower than this [m], each ray can only be of the nearest edge. Half of this,
FORGETTING, STEADY, INDIFFERENT and STRAY: nothing changes beyond chance; twice: places are found
after 1.9 and 2.1 s, not 1.6 and 1.1, and 36.6 % are certain, not 38.3 (``--few``)."""
SHARP = 0.008
"""A pose that is known better than this [m, rad] is weighed at its mean alone."""
STEADY, FORGETTING = 0.6, 0.2
"""How much more log-likelihood a scan may count than the mean of the scans before it, and the share
of a new scan in that mean."""
INDIFFERENT = 0.5
"""Smaller losses of log-likelihood do not count: a single ray makes as much. Such small differences
come from where a fit ends, and they would add up."""

ONE_THING, FORGIVEN = 6.0, 0.1
"""Most log-weight that a confirmed place loses by one thing on the floor, and how much of that is
given back with each scan. A shoe that looks like the tape of another place is seen in a dozen
scans, but only once: it must not outweigh all that was seen before it. Half and twice of ONE_THING:
no claim changes (``--few``)."""

STRAY = 0.05
"""Clusters below this share of a track's heaviest cluster are not separate places."""


class TrackFilter(Filter, Protocol):
    """A filter that can serve as one track of many."""

    share: float
    """Share of its usual number of particles that it may keep."""


@dataclass
class Track:
    """A hypothesis that lives on from scan to scan, with its own filter."""

    filter: TrackFilter
    log_weight: float
    """Relative to the heaviest track."""
    born: int = 0
    """Number of kept scans when it was found, or last came unstuck."""
    confirmed: bool = False
    """Whether it was the only likely place for long: then no single thing outweighs it."""
    _left: float = ONE_THING
    """Log-weight that it may still lose by the thing that is seen now, if it is confirmed."""
    _gains: tuple[float, ...] = ()
    """How much better the last scans fit where they were laid than at the track; only of successive
    scans that were laid far off."""
    _fitting: Pose2 | None = None
    """Pose at which the last scan fits."""
    _mean_loss: float = 0.0
    """Mean loss of log-likelihood by the last scans, relative to the best place."""

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The filter's hypotheses without stray particles: these make equal weights flicker."""
        hypotheses = self.filter.hypotheses
        kept = [each for each in hypotheses if each.weight > STRAY * hypotheses[0].weight]
        if len(kept) == len(hypotheses):
            return hypotheses
        all_of_it = sum(each.weight for each in hypotheses) / sum(each.weight for each in kept)
        return tuple(replace(each, weight=each.weight * all_of_it) for each in kept)

    @property
    def fits_like_best(self) -> bool:
        """Whether the last scans fit this place about as well as the best one."""
        return self._mean_loss < INDIFFERENT

    @property
    def best(self) -> Hypothesis:
        """The filter's heaviest hypothesis."""
        return self.filter.hypotheses[0]

    @property
    def pose(self) -> Pose2:
        """Pose of the filter's heaviest hypothesis."""
        return self.best.pose

    def fit(self, rays: Array, setup: Setup) -> float:
        """Return the mean log-likelihood of rays at this place, after they are laid on the edges.

        Laying them removes the random error of the filter's mean. So of places that look the same,
        none becomes likelier than another.
        """
        best = self.best
        narrow = best.covariance[0, 0] + best.covariance[1, 1] < NARROW**2
        matcher = setup.fine_matcher if narrow else setup.matcher
        fitting, far, current, target = _laid(
            best.pose.to_array(), best.covariance, rays, matcher, setup.evidence
        )
        self._fitting = Pose2(*fitting.tolist())
        self._gains = (*self._gains, target - current)[-STUCK:] if far > FAR else ()
        # Beyond this distance, the track would gain weight by scans that fit another place.
        return target if far < FARTHEST else current

    def unmatched_fit(self, rays: Array, setup: Setup) -> float:
        """Return the mean log-likelihood of rays at the filter's own pose, or close to it.

        After rays are laid on the edges, a wrong place would fit too well to be noticed.
        """
        poses = _around(self.pose.to_array(), self.best.covariance)
        return float(setup.evidence.log_likelihoods(poses, rays, within=0.0).max())

    def lose(self, loss: float, most: float) -> None:
        """Subtract a scan's loss of log-likelihood, relative to the best place, from the weight.

        The errors of successive scans are correlated: a piece of tape that is seen badly stays so
        for a dozen pictures. So a scan counts little more than the mean of the scans before it, and
        a steady difference counts in full after some scans, or slowly if the place is confirmed.
        """
        counted = min(loss, self._mean_loss + STEADY, most)
        self._mean_loss += FORGETTING * (min(loss, most) - self._mean_loss)
        if counted > INDIFFERENT:
            if self.confirmed:
                counted = min(counted, self._left)
            self.log_weight -= counted
            self._left -= counted
        self._left = min(max(self._left, 0.0) + FORGIVEN, ONE_THING)

    def restart_if_stuck(self) -> bool:
        """Restart where the scans fit, if they have fitted far off, and better, for long enough.

        Returns:
            Whether it restarted.
        """
        better = len(self._gains) == STUCK and self._gains[-1] > 0 and sum(self._gains) > 0
        if better and self._fitting is not None:
            self.filter.set_pose(self._fitting, self.best.covariance + MATCH_COVARIANCE)
            self._gains = ()
            return True
        return False


def distinct(tracks: Sequence[Track], parameters: HypothesisParameters) -> list[Track]:
    """Return the tracks, heaviest first, without the hopeless ones and without duplicates.

    A duplicate is at the place of a heavier track.
    """
    kept: list[Track] = []
    for track in sorted(tracks, key=lambda track: -track.log_weight):
        hopeless = kept and track.log_weight < kept[0].log_weight + parameters.log_hopeless
        if not hopeless and not any(parameters.alike(track.pose, other.pose) for other in kept):
            kept.append(track)
    return kept[: parameters.max_hypotheses]


@compiled()
def _laid(
    pose: Array, covariance: Array, rays: Array, matcher: ScanMatcher, evidence: RayEvidence
) -> tuple[Array, float, float, float]:
    """Lay rays (n, 9) on the edges from a hypothesis, and weigh both poses by them.

    One call: each hypothesis needs it for each picture, and five calls with small arrays between
    them took longer.

    Args:
        pose: the hypothesis's mean (3,).
        covariance: the hypothesis's covariance (3, 3).
        rays: the scan.
        matcher: lays them.
        evidence: weighs the poses.

    Returns:
        Where the rays fit (3,); the squared Mahalanobis distance to there; and the mean
        log-likelihood of the rays at the hypothesis (nan if it is not FAR), and where they fit.
    """
    known = inverse(covariance + MATCH_COVARIANCE)
    fitting, information, _ = fit_rays(pose, known, rays, matcher)
    fitting[2] = (fitting[2] + math.pi) % (2 * math.pi) - math.pi
    away = fitting - pose
    away[2] = (away[2] + math.pi) % (2 * math.pi) - math.pi
    far = away @ known @ away
    # (C^-1 + S)^-1 of covariance C and the scan's information S, even if one is singular.
    left = solved(np.eye(3) + covariance @ (information - known), covariance)
    target = ray_log_likelihoods(_around(fitting, left), rays, evidence, 0.0).max()
    current = np.nan
    if far > FAR:
        current = ray_log_likelihoods(pose.reshape(1, 3), rays, evidence, 0.0)[0]
    return fitting, float(far), current, target


@compiled()
def _around(pose: Array, covariance: Array) -> Array:
    """Return a pose and those one standard deviation beside it (7, 3); a well known pose alone.

    If a robot turns and sees nothing, its heading gets uncertain. Then a missed edge means nothing
    if it is expected at the mean pose, but not beside it.
    """
    poses = np.empty((7, 3))
    for i in range(7):
        for j in range(3):
            poses[i, j] = pose[j]
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


def joint_hypotheses(tracks: list[Track], weights: Array) -> tuple[Hypothesis, ...]:
    """Return the hypotheses of all tracks with weights (n,), heaviest first."""
    result = [
        Hypothesis(item.weight * weight, item.pose, item.covariance)
        for track, weight in zip(tracks, weights.tolist(), strict=True)
        for item in track.hypotheses
    ]
    return tuple(sorted(result, key=lambda item: -item.weight))
