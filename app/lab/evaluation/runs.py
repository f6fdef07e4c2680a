"""A drive as each method saw it: truth, odometry and estimate at every picture."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.engine.build import own_models
from app.engine.localization import Localization
from app.lab.evaluation.drives import Drive
from app.settings.config import Config
from robot.description.spec import RobotSpec
from robot.geometry import Array, Pose2
from robot.localization.integrity import State
from robot.scanning.line_scanner import LineScanner


class EvaluationError(ValueError):
    """What was asked for cannot be evaluated; the message says why and what can."""


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
    """Of the estimate (n, 3, 3) [m, m, rad], as the filter says."""
    cpu: Array
    """Time of a processor that the filter took (n,) [s]."""
    certain: NDArray[np.bool_]
    """Whether it claimed to be certain (n,)."""


def follow(drive: Drive, config: Config, told: Pose2, covariance: Array | None = None) -> Run:
    """Let the program's localization follow a recorded drive.

    It is told and asked in the order in which the engine does, and draws the same numbers, so that
    the answers are those of the program.

    Args:
        drive: what the robot saw and where it was.
        config: seed and localization, and models of the user's own.
        told: the pose at the start.
        covariance: of the told pose (3, 3) [m, m, rad]; None is as a pose told without one.

    Raises:
        EvaluationError: a model of the user's own is broken, or nothing was ever estimated.
    """
    chance = np.random.default_rng(config.seed).spawn(2)[1]
    scanner = LineScanner(RobotSpec.load().floor_view, config.scanner)
    own = own_models(config, drive.field)
    localization = Localization(scanner, drive.field, config.localization, chance, own)
    if covariance is None:
        localization.set_pose(told, None, None)
    else:
        localization.set_pose_with(told, covariance)
    map_from_odom = drive.ticks[0].truth @ drive.ticks[0].odometry.inverse()
    rows: list[tuple[float, Pose2, Pose2, Pose2, Array, float, bool]] = []
    for tick in drive.ticks:
        localization.note(tick.odometry)
        if tick.scan is None or tick.odometry_at_scan is None:
            continue
        began = time.thread_time()
        localization.take(tick.scan, tick.odometry_at_scan)
        took = time.thread_time() - began
        if localization.fault:
            raise EvaluationError(localization.fault)
        belief, stamp = localization.belief, tick.scan.stamp
        if belief is not None:
            reckoned = map_from_odom @ tick.odometry_at_scan
            estimate = belief.pose(tick.odometry_at_scan)
            rows.append(
                (
                    stamp,
                    drive.truth_at(stamp),
                    reckoned,
                    estimate,
                    belief.estimate.covariance,
                    took,
                    localization.integrity.state is State.CERTAIN,
                )
            )
    if len(rows) < 3:
        raise EvaluationError("fewer than three pictures were taken; drive for longer")
    stamps, truth, odometry, estimates, covariances, cpu, certain = zip(*rows, strict=True)
    return Run(
        np.array(stamps),
        _poses(truth),
        _poses(odometry),
        _poses(estimates),
        np.array(covariances),
        np.array(cpu),
        np.array(certain),
    )


def _poses(poses: tuple[Pose2, ...]) -> Array:
    return np.array([pose.to_array() for pose in poses])
