"""Judge earlier reports after a better place was found."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from app.lab.localize.candidate import PRIOR_MAP_LENGTHS, Candidate
from app.lab.localize.localized import ReportedPose
from robot.geometry import Pose2
from robot.scan import Scan

NEAR_M = 1.5
"""A reported pose stands if the robot, followed back, comes nearer than this."""


@dataclass(frozen=True, slots=True)
class Moment:
    """An update, and the leader's result at that time."""

    odometry: Pose2
    scan: Scan
    place: Pose2
    """The leader's pose, in the frame of the map's cells."""
    latest: float
    """The leader's log-likelihood per ray."""


def withdraw(
    tolds: Iterable[ReportedPose], moments: Sequence[Moment], back: Candidate, margin: float
) -> None:
    """Mark the reported poses that hindsight does not support.

    The robot is followed back from its current place, through the remembered scans. A pose stands
    if the way back comes to the same place. It also stands if the way back explains the scans
    around it worse than the pose did: then the report was right, and the robot was carried off
    later. Poses older than the memory are judged like the oldest remembered one.

    Args:
        tolds: the reported poses, which are marked.
        moments: the remembered updates, in order of time.
        back: a candidate at the current place.
        margin: by how much a pose has to explain the scans better, in log-likelihood per ray.
    """
    near, better = [], []
    for moment in reversed(moments):
        back.take_too(moment.odometry, moment.scan)
        assert back.estimate is not None
        near.append(back.estimate.pose.distance_to(moment.place) < NEAR_M)
        better.append(moment.latest - back.latest)
    around = np.ones(min(PRIOR_MAP_LENGTHS, len(better)))
    mean = np.convolve(better, around, "same") / np.convolve(np.ones(len(better)), around, "same")
    stands = (np.array(near) | (mean > margin))[::-1]
    stamps = np.array([moment.scan.stamp for moment in moments])
    for item in tolds:
        position = max(int(np.searchsorted(stamps, item.stamp, side="right")) - 1, 0)
        item.withdrawn |= not stands[position]
