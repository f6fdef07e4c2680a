"""The poses of one drive at every picture: truth, odometry and estimate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.engine.localization import Localization
from app.lab.evaluation.drives import Drive, EvaluationError, follow_drive
from app.settings.config import Config
from robot.geometry import Array, Pose2
from robot.localization.estimate import State


@dataclass(frozen=True)
class Run:
    """Poses (n, 3) [m, m, rad] in the map, at the stamps of n pictures."""

    stamps: Array
    """(n,) [s]"""
    truth: Array
    odometry: Array
    """Dead reckoning from the true start."""
    estimate: Array
    covariance: Array
    """The filter's covariance of the estimate (n, 3, 3) [m, m, rad]."""
    cpu: Array
    """Processor time of the filter (n,) [s]."""
    certain: NDArray[np.bool_]
    """Whether the filter claimed to be certain (n,)."""


def follow(drive: Drive, config: Config, pose2: Pose2, covariance: Array | None = None) -> Run:
    """Let the program follow a recorded drive.

    Args:
        drive: what the robot saw and where it was.
        config: seed, localization and the user's own models.
        pose2: the pose that the filter is given at the start.
        covariance: of that pose (3, 3) [m, m, rad]; None gives the pose without a covariance.

    Raises:
        EvaluationError: one of the user's own models is broken, or there are fewer than three
            estimates.
    """

    def begin(localization: Localization) -> None:
        if covariance is None:
            localization.set_pose(pose2, None, None)
        else:
            localization.set_pose_with(pose2, covariance)

    map_from_odom = drive.ticks[0].truth @ drive.ticks[0].odometry.inverse()
    rows: list[tuple[float, Pose2, Pose2, Pose2, Array, float, bool]] = []
    for tick, odometry, localization in follow_drive(drive, config, begin):
        belief, scan = localization.belief, tick.scan
        if belief is not None and scan is not None:
            rows.append(
                (
                    scan.stamp,
                    drive.truth_at(scan.stamp),
                    map_from_odom @ odometry,
                    belief.pose(odometry),
                    belief.estimate.covariance,
                    localization.seconds,
                    localization.integrity.state is State.CERTAIN,
                )
            )
    if len(rows) < 3:
        raise EvaluationError("fewer than three pictures were taken; drive for longer")
    stamps, truth, reckoned, estimates, covariances, cpu, certain = zip(*rows, strict=True)
    return Run(
        np.array(stamps),
        _poses(truth),
        _poses(reckoned),
        _poses(estimates),
        np.array(covariances),
        np.array(cpu),
        np.array(certain),
    )


def _poses(poses: tuple[Pose2, ...]) -> Array:
    return np.array([pose.to_array() for pose in poses])
