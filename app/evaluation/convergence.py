"""When does an estimate that began wrong become right?"""

from __future__ import annotations

import math

import numpy as np

from app.evaluation.runs import Run
from app.trajectories.metrics import rms
from robot.geometry import Array, wrap_angle

RIGHT_XY, RIGHT_THETA = 0.02, 0.1
"""An estimate so close to the truth is right [m], [rad]."""
HELD = 1.0
"""For so long, to count [s]."""


def errors(run: Run, poses: Array) -> tuple[Array, Array]:
    """Distances (n,) [m] and turns (n,) [rad] from the truth to poses (n, 3) of a run."""
    off = poses - run.truth
    return np.linalg.norm(off[:, :2], axis=1), wrap_angle(off[:, 2])


def time_to_converge(stamps: Array, distances: Array, turns: Array) -> float:
    """Time [s] after the first of stamps (n,) from which on the estimate is right for a second.

    Args:
        stamps: (n,) [s].
        distances: from the truth (n,) [m].
        turns: from the truth (n,) [rad].

    Returns:
        inf if it never is.
    """
    right = (distances < RIGHT_XY) & (np.abs(turns) < RIGHT_THETA)
    for first in np.flatnonzero(right & ~np.concatenate([[False], right[:-1]])):
        until = int(np.searchsorted(stamps, stamps[first] + HELD - 1e-9))
        if until < len(stamps) and right[first : until + 1].all():
            return float(stamps[first] - stamps[0])
    return math.inf


def steady_error(run: Run) -> float:
    """Root mean square of the distances [m] once it is settled; nan if it never is."""
    late = settled(run)
    return rms(errors(run, run.estimate)[0][late]) if late.any() else math.nan


def settled(run: Run) -> Array:
    """Which pictures (n,) come a second or more after the estimate became right; none if never."""
    seconds = time_to_converge(run.stamps, *errors(run, run.estimate))
    late: Array = run.stamps >= run.stamps[0] + seconds + HELD
    return late
