"""What a place that was found later says of what was told before."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from app.lab.localize.candidate import REMEMBERED, Candidate
from app.lab.localize.localized import ReportedPose
from robot.geometry import Pose2
from robot.scan import Scan

NEAR_M = 1.5
"""What was told stands if the robot, followed back, comes so near."""


@dataclass(frozen=True, slots=True)
class Moment:
    """An update, and what the belief that led then made of it."""

    odometry: Pose2
    scan: Scan
    place: Pose2
    """In the frame of the map's cells."""
    latest: float
    """Log-likelihood a ray there."""


def withdraw(
    tolds: Iterable[ReportedPose], moments: Sequence[Moment], back: Candidate, margin: float
) -> None:
    """Mark what cannot be defended any more.

    The robot is followed back from the place that it has now, through the scans that are
    remembered. A pose stands if that comes to the same place, or explains the scans around it worse
    than the pose did: so was a robot right that was carried off later. What is older than what is
    remembered goes as the oldest of it does.

    Args:
        tolds: what was told; poses are marked.
        moments: what is remembered, in order of time.
        back: at the place of now.
        margin: by which a pose has to explain scans better, in log-likelihood a ray.
    """
    near, better = [], []
    for moment in reversed(moments):
        back.take_too(moment.odometry, moment.scan)
        assert back.estimate is not None
        near.append(back.estimate.pose.distance_to(moment.place) < NEAR_M)
        better.append(moment.latest - back.latest)
    around = np.ones(min(REMEMBERED, len(better)))
    mean = np.convolve(better, around, "same") / np.convolve(np.ones(len(better)), around, "same")
    stands = (np.array(near) | (mean > margin))[::-1]
    stamps = np.array([moment.scan.stamp for moment in moments])
    for item in tolds:
        position = max(int(np.searchsorted(stamps, item.stamp, side="right")) - 1, 0)
        item.withdrawn |= not stands[position]
