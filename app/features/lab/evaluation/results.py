"""The results of all runs, in the form of ``results.json``: metres, radians, seconds."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from app.features.lab.evaluation.runs import (
    SHOWN,
    Run,
    Score,
    errors,
    in_place,
    lost_again,
    right_to_the_end,
    score,
    steady_error,
    time_to_converge,
)
from app.features.lab.trajectories.consistency import ConsistencyError, anees_bounds, nees
from app.trajectories.trajectory import Trajectory
from robot.geometry import Array, wrap_angle

LEVEL = 0.95
"""How often an interval should hold the true mean."""
DRAW_BATCH = 2**22
"""Numbers that are drawn at a time."""
METHODS = ("odometry", "amcl")
"""Dead reckoning alone, and the configured localization."""
SETTLE = 1.0
"""Covariances are compared with errors from this time after the start on [s]."""
Table = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Summary:
    """Mean, median and maximum of values of one unit."""

    mean: float
    median: float
    max: float


def summary(values: ArrayLike) -> Summary:
    """Return mean, median and maximum.

    Raises:
        ValueError: there are no values, or one is not finite.
    """
    checked = _checked(values)
    return Summary(float(checked.mean()), float(np.median(checked)), float(checked.max()))


def bootstrap_interval(values: ArrayLike, draws: int = 10_000) -> tuple[float, float]:
    """Return the percentile bootstrap interval of the mean; the same at each call.

    After Efron and Tibshirani (1993), chapter 13.

    Args:
        values: one for each run, independent of each other.
        draws: how many samples are drawn with replacement.

    Raises:
        ValueError: there are no values, or one is not finite.
    """
    checked = _checked(values)
    rng = np.random.default_rng(0)
    means, rows = [], max(DRAW_BATCH // len(checked), 1)
    for start in range(0, draws, rows):
        shape = (min(rows, draws - start), len(checked))
        means.append(checked[rng.integers(len(checked), size=shape)].mean(axis=1))
    low, high = np.quantile(np.concatenate(means), [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)


def _checked(values: ArrayLike) -> Array:
    checked = np.asarray(values, dtype=np.float64).ravel()
    if not len(checked) or not np.isfinite(checked).all():
        raise ValueError("no values, or not all finite; valid are finite numbers, one a run")
    return checked


def poses_of(run: Run, method: str) -> Array:
    """Return the poses (n, 3) of a method or of the truth."""
    return {"truth": run.truth, "odometry": run.odometry, "amcl": run.estimate}[method]


def trajectory(run: Run, method: str) -> Trajectory:
    """Return the poses of a method or of the truth as a trajectory."""
    return Trajectory.of_poses(run.stamps, poses_of(run, method), method)


def spread(values: Sequence[float]) -> Table:
    """Return mean, median, maximum, bootstrap interval of the mean, and each robot's value.

    A value that is not finite is None; so are the statistics if there is no finite value.
    """
    each = [float(value) if math.isfinite(value) else None for value in values]
    result = [value for value in each if value is not None]
    if not result:
        return dict.fromkeys(("mean", "median", "max", "ci95")) | {"per_seed": each}
    return asdict(summary(result)) | {"ci95": list(bootstrap_interval(result)), "per_seed": each}


def method_table(scores: Sequence[Score]) -> Table:
    """Return the errors of one method in one condition."""

    def over(pick: Callable[[Score], float]) -> Table:
        return spread([pick(item) for item in scores])

    relative = {
        delta: {
            "trans_rmse_m": over(lambda each, d=delta: each.relative[d][0]),  # type: ignore[misc]
            "rot_rmse_rad": over(lambda item, d=delta: item.relative[d][1]),  # type: ignore[misc]
        }
        for delta in scores[0].relative
    }
    return {
        "ate_rmse_m": over(lambda item: item.ate),
        "ate_aligned_rmse_m": over(lambda item: item.ate_aligned),
        "heading_rmse_rad": over(lambda item: item.heading),
        "rpe_trans_rmse_m": relative[SHOWN]["trans_rmse_m"],
        "rpe_rot_rmse_rad": relative[SHOWN]["rot_rmse_rad"],
        "rpe": relative,
    }


def condition_table(runs: Sequence[Run]) -> Table:
    """Return the results of all robots in one world with one start."""
    truths = [trajectory(run, "truth") for run in runs]
    return {
        "methods": {
            method: method_table(
                [
                    score(truth, trajectory(run, method))
                    for truth, run in zip(truths, runs, strict=True)
                ]
            )
            for method in METHODS
        },
        "convergence": convergence_table(runs),
        "nees": nees_table(runs),
    }


def convergence_table(runs: Sequence[Run]) -> Table:
    """Return when estimates became right, their error after that, and whether they stayed right.

    They become right within 20 mm and 0.1 rad of the truth for a second, and stay right within
    50 mm and 10 degrees.
    """
    stayed, left = [], []
    for run in runs:
        right = in_place(*errors(run, run.estimate))
        stayed.append(right_to_the_end(run.stamps, right))
        left.append(lost_again(run.stamps, right, run.certain))
    seconds = [time_to_converge(run.stamps, *errors(run, run.estimate)) for run in runs]
    return {
        "converged": sum(map(math.isfinite, seconds)),
        "of": len(runs),
        "right_to_the_end": sum(stayed),
        "right_to_the_end_per_seed": stayed,
        "lost_again": sum(left),
        "lost_again_per_seed": left,
        "seconds": spread(seconds),
        "steady_ate_rmse_m": spread([steady_error(run) for run in runs]),
    }


def nees_table(runs: Sequence[Run]) -> Table | None:
    """Compare the filter's covariance with its errors by the mean NEES, e' P^-1 e, of the robots.

    There is one mean for each picture. If the filter is consistent, 95 % of these means lie within
    the bounds.

    Returns:
        None if a covariance is singular, or if the runs differ in their number of pictures.
    """
    try:
        each = [_nees(run) for run in runs]
    except ConsistencyError:
        return None
    if len({len(item) for item in each}) != 1 or not len(each[0]):
        return None
    low, high = anees_bounds(len(runs))
    means = np.mean(each, axis=0)
    return {
        "mean": float(means.mean()),
        "bounds": [low, high],
        "within": float(((means >= low) & (means <= high)).mean()),
        "too_sure": float((means > high).mean()),
        "too_cautious": float((means < low).mean()),
    }


def _nees(run: Run) -> Array:
    late = run.stamps >= run.stamps[0] + SETTLE
    offset = run.estimate - run.truth
    offset[:, 2] = wrap_angle(offset[:, 2])
    return nees(offset[late], run.covariance[late])
