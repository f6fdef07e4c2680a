"""The errors of a method in one run (Sturm et al. 2012)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from app.lab.trajectories.metrics import (
    Unit,
    ate_rmse,
    heading_errors,
    motion_errors,
    relative_pairs,
    rms,
)
from app.lab.trajectories.trajectory import Trajectory, TrajectoryError

DELTAS: tuple[tuple[float, Unit], ...] = (
    (0.1, "s"), (0.5, "s"), (1.0, "s"), (0.1, "m"), (0.5, "m"), (1.0, "m"),
)  # fmt: skip
"""Times and path lengths over which motions are compared."""
SHOWN = "1 s"
"""The one of these that tables use to compare methods."""


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
