"""Turns given hypotheses or poses into the tracks and priors of a start."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud, Filter
from robot.localization.hypotheses.prior import LEAST_VARIANCE, Prior
from robot.localization.hypotheses.track import Track, TrackFilter
from robot.localization.particles.clusters import Cells, find_clusters
from robot.localization.setup import Setup

ENOUGH = 50
"""Least number of poses to start a filter from; fewer are replaced by their mean and spread."""
WIDEST = 10.0
"""Clusters wider than this multiple of the merge distance (``same_xy``) are ignored."""
COVERED = 0.9
"""Least share of a cloud's weight that its clusters must have."""


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
