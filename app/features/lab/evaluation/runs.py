"""One drive: its poses at every picture, their errors, and when an estimate becomes right."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.engine.localization import Localization
from app.features.lab.evaluation.drives import Drive, EvaluationError, follow_drive
from app.features.lab.trajectories.metrics import (
    Unit,
    ate_rmse,
    heading_errors,
    motion_errors,
    relative_pairs,
    rms,
)
from app.settings.config import Config
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.estimate import State

DELTAS: tuple[tuple[float, Unit], ...] = (
    (0.1, "s"), (0.5, "s"), (1.0, "s"), (0.1, "m"), (0.5, "m"), (1.0, "m"),
)  # fmt: skip
"""Times and path lengths over which motions are compared."""
SHOWN = "1 s"
"""The one of these that tables use to compare methods."""
RIGHT_XY, RIGHT_THETA = 0.02, 0.1
"""An estimate closer than this to the truth is right [m], [rad]."""
PLACE_XY, PLACE_THETA = 0.05, math.radians(10)
"""An estimate farther than this from the truth is at another place [m], [rad]."""
HOLD_SECONDS = 1.0
"""A condition counts only if it holds for this long [s]."""
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
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
        localization.set_pose(pose2, covariance)

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


@dataclass(frozen=True)
class Score:
    """Root mean squares over one run."""

    ate: float
    """Of the position, without alignment [m]."""
    ate_aligned: float
    """Of the position, after the best rigid alignment [m]; nan if the robot never moved."""
    heading: float
    """[rad]"""
    relative: dict[str, tuple[float, float]]
    """Of the motion over each time or path length, by its name: translation [m] and rotation [rad];
    nan if the run is too short."""


def score(truth: Trajectory, estimate: Trajectory) -> Score:
    """Return the errors of paired poses.

    Raises:
        TrajectoryError: the poses are not paired.
    """
    return Score(
        ate_rmse(truth, estimate),
        _aligned(truth, estimate),
        rms(heading_errors(truth, estimate)),
        {f"{delta:g} {unit}": _relative(truth, estimate, delta, unit) for delta, unit in DELTAS},
    )


def _aligned(truth: Trajectory, estimate: Trajectory) -> float:
    try:
        return ate_rmse(truth, estimate, aligned=True)
    except TrajectoryError:
        return math.nan


def _relative(
    truth: Trajectory, estimate: Trajectory, delta: float, unit: Unit
) -> tuple[float, float]:
    i, j = relative_pairs(truth, delta, unit)
    if not len(i):
        return math.nan, math.nan
    translation, rotation = motion_errors(truth, estimate, i, j)
    return rms(translation), rms(rotation)


def errors(run: Run, poses: Array) -> tuple[Array, Array]:
    """Return distances (n,) [m] and turns (n,) [rad] from the truth to poses (n, 3) of a run."""
    offset = poses - run.truth
    return np.linalg.norm(offset[:, :2], axis=1), wrap_angle(offset[:, 2])


def time_to_converge(stamps: Array, distances: Array, turns: Array) -> float:
    """Return the time [s] from the first stamp until the estimate becomes right for a second.

    Args:
        stamps: (n,) [s].
        distances: from the truth (n,) [m].
        turns: from the truth (n,) [rad].

    Returns:
        When that second begins; inf if the estimate is never right for a second.
    """
    right = (distances < RIGHT_XY) & (np.abs(turns) < RIGHT_THETA)
    first = first_sustained(stamps, right)
    return math.inf if first is None else float(stamps[first] - stamps[0])


def first_sustained(stamps: Array, some: Mask) -> int | None:
    """Return the index of the first picture from which a condition holds for a second.

    Args:
        stamps: (n,) [s].
        some: (n,) whether the condition holds.

    Returns:
        None if the condition never holds for a second.
    """
    for first in np.flatnonzero(some & ~np.concatenate([[False], some[:-1]])):
        until = int(np.searchsorted(stamps, stamps[first] + HOLD_SECONDS - 1e-9))
        if until < len(stamps) and some[first : until + 1].all():
            return int(first)
    return None


def in_place(distances: Array, turns: Array) -> Mask:
    """Whether estimates (n,) are at the true place, by distance [m] and turn [rad]."""
    near: Mask = (distances < PLACE_XY) & (np.abs(turns) < PLACE_THETA)
    return near


def right_to_the_end(stamps: Array, right: Mask) -> bool:
    """Whether the estimate became right for a second and was right at all later pictures (n,)."""
    first = first_sustained(stamps, right)
    return first is not None and bool(right[first:].all())


def lost_again(stamps: Array, right: Mask, certain: Mask) -> bool:
    """Whether it was right and certain for a second, and wrong at a later picture (n,)."""
    first = first_sustained(stamps, right & certain)
    return first is not None and not right[first:].all()


def steady_error(run: Run) -> float:
    """Return the root mean square distance [m] after settling; nan if it never settles."""
    late = settled(run)
    return rms(errors(run, run.estimate)[0][late]) if late.any() else math.nan


def settled(run: Run) -> Array:
    """Return which pictures (n,) come a second or more after the estimate became right.

    No picture does if the estimate never becomes right.
    """
    seconds = time_to_converge(run.stamps, *errors(run, run.estimate))
    late: Array = run.stamps >= run.stamps[0] + seconds + HOLD_SECONDS
    return late
