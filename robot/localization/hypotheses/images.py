"""Places that a field's own symmetry makes look like another one: nothing ever tells them apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from robot.geometry import Array, Pose2
from robot.localization.hypotheses.track import Track
from robot.localization.hypothesis_parameters import HypothesisParameters

EQUAL = -3.0
"""A place of so much log-weight beside the heaviest has its images followed."""


@dataclass(frozen=True, slots=True)
class Image:
    """A place that looks like one that is followed."""

    pose: Pose2
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""
    log_weight: float


def missing_images(
    tracks: Sequence[Track], symmetries: Sequence[Pose2], parameters: HypothesisParameters
) -> Iterator[Image]:
    """Images of the heaviest tracks that are not followed; those that are get the same weight."""
    for track in tracks:
        if track.log_weight < EQUAL:
            continue
        for turned in symmetries:
            pose = turned @ track.pose
            target = [item for item in tracks if parameters.alike(pose, item.pose)]
            for each in target:
                each.log_weight = max(each.log_weight, track.log_weight)
            if not target:
                covariance = _turned(track.best.covariance, turned.theta)
                yield Image(pose, covariance, track.log_weight)


def _turned(covariance: Array, turn: float) -> Array:
    """A covariance (3, 3) after a turn of the map [rad]."""
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    turned: Array = rotation @ covariance @ rotation.T
    return turned
