"""Images of a place: a symmetric field looks the same there, so no scan can distinguish them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from robot.geometry import Array, Pose2, turned_covariance
from robot.localization.hypotheses.track import Track
from robot.localization.parameters import HypothesisParameters

EQUAL = -3.0
"""Log-weight relative to the heaviest place from which on the images of a place are followed."""


@dataclass(frozen=True, slots=True)
class Image:
    """A place that looks like a followed one."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    log_weight: float


def missing_images(
    tracks: Sequence[Track], symmetries: Sequence[Pose2], parameters: HypothesisParameters
) -> Iterator[Image]:
    """Yield images of the heaviest tracks that are not followed; the others get the same weight."""
    for track in tracks:
        if track.log_weight < EQUAL:
            continue
        for turned in symmetries:
            pose = turned @ track.pose
            target = [item for item in tracks if parameters.alike(pose, item.pose)]
            for each in target:
                each.log_weight = max(each.log_weight, track.log_weight)
            if not target:
                covariance = turned_covariance(track.best.covariance, turned.theta)
                yield Image(pose, covariance, track.log_weight)
