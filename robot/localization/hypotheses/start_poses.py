"""Given hypotheses or poses: the tracks and priors of a start, and priors moved by odometry."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud, Filter, Setup
from robot.localization.hypotheses.track import Track, TrackFilter
from robot.localization.models.motion_models import MotionModel, follow
from robot.localization.particles.clusters import Cells, find_clusters

LEAST_VARIANCE = np.diag(np.square([0.005, 0.005, 0.02]))
"""Least covariance of a given pose: nobody knows it better than this [m², m², rad²]."""
ENOUGH = 50
"""Least number of poses to start a filter from; fewer are replaced by their mean and spread."""
WIDEST = 10.0
"""Clusters wider than this multiple of the merge distance (``same_xy``) are ignored."""
COVERED = 0.9
"""Least share of a cloud's weight that its clusters must have."""


@dataclass(frozen=True, slots=True, eq=False)
class Prior:
    """A pose with its covariance."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    log_weight: float = 0.0
    """Relative to the likeliest given pose."""

    def moved(self, step: Pose2, motion: MotionModel) -> Prior:
        """Return the prior after a step of odometry."""
        mean, noise = motion.moments(step)
        return Prior(*follow(self.pose, self.covariance, mean, noise), self.log_weight)

    def log_likelihood(self, pose: Pose2) -> float:
        """Return the log-likelihood of a pose, relative to the likeliest given pose."""
        offset = self.pose.offset_to(pose)
        return self.log_weight - 0.5 * float(
            offset @ np.linalg.solve(self.covariance + LEAST_VARIANCE, offset)
        )


def log_prior(priors: Sequence[Prior], pose: Pose2, log_kidnapped: float) -> float:
    """Return the prior log-likelihood of a found pose, relative to the followed one."""
    if not priors:
        return log_kidnapped
    likeliest = max(prior.log_likelihood(pose) for prior in priors)
    return float(np.logaddexp(likeliest, log_kidnapped))


@dataclass(frozen=True, slots=True)
class StartPose:
    """A hypothesis to start from, or a cluster of poses."""

    hypothesis: Hypothesis
    cloud: Cloud | None = None
    """The poses of a cluster; None for a hypothesis alone."""

    def begin(self, item: Filter) -> None:
        """Start a filter at this place."""
        if self.cloud is not None and len(self.cloud.weights) >= ENOUGH:
            item.set_cloud(self.cloud)
        else:
            covariance = self.hypothesis.covariance + LEAST_VARIANCE
            item.set_pose(self.hypothesis.pose, covariance)


def start_tracks(
    places: list[StartPose], new_filter: Callable[[Setup, float], TrackFilter], setup: Setup
) -> tuple[list[Track], list[Prior]]:
    """Return a track and a prior for each place, the heaviest first."""
    tracks, told_priors = [], []
    total = sum(place.hypothesis.weight for place in places)
    for place in places:
        given = place.hypothesis
        item = new_filter(setup, given.weight / total)
        place.begin(item)
        log_weight = math.log(given.weight / places[0].hypothesis.weight)
        tracks.append(Track(item, log_weight))
        told_priors.append(Prior(given.pose, given.covariance, log_weight))
    return tracks, told_priors


def find_start_clusters(cloud: Cloud, setup: Setup) -> list[StartPose]:
    """Return the clusters of a cloud, heaviest first; none if it is spread over the field."""
    p = setup.hypotheses
    cells = Cells(setup.filter.cell_xy, max(1, round(2 * math.pi / setup.filter.cell_theta)))
    result = find_clusters(cloud.poses, cloud.weights, cells, p.max_hypotheses)
    places = []
    for label, hypothesis in enumerate(result.hypotheses):
        if (
            hypothesis.weight > 0
            and math.sqrt(hypothesis.covariance[:2, :2].trace()) < WIDEST * p.same_xy
        ):
            mine = np.flatnonzero(result.labels == label)
            weights = cloud.weights[mine]
            places.append(StartPose(hypothesis, Cloud(cloud.poses[mine], weights / weights.sum())))
    covered = sum(place.hypothesis.weight for place in places)
    if covered < COVERED:
        return []
    return [
        replace(
            place, hypothesis=replace(place.hypothesis, weight=place.hypothesis.weight / covered)
        )
        for place in places
    ]
