"""How far a method was off in one run (Sturm et al. 2012)."""

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
"""Times and ways over which the motion is compared."""
SHOWN = "1 s"
"""Of these the one by which methods are compared in a table."""


@dataclass(frozen=True)
class Score:
    """Root mean squares over one run."""

    ate: float
    """Position, as it is [m]."""
    ate_aligned: float
    """After a rigid motion that makes it least [m]; nan if the robot never moved."""
    heading: float
    """[rad]"""
    relative: dict[str, tuple[float, float]]
    """Motion over a time or a way, by its name: translation [m] and rotation [rad]; nan if the run
    is too short."""


def score(truth: Trajectory, estimate: Trajectory) -> Score:
    """Of pairs of poses.

    Raises:
        TrajectoryError: they are not pairs.
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
