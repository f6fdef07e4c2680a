"""When does an estimate that began wrong become right, and does it stay so?"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from app.lab.evaluation.runs import Run
from app.lab.trajectories.metrics import rms
from robot.geometry import Array, wrap_angle

RIGHT_XY, RIGHT_THETA = 0.02, 0.1
"""An estimate so close to the truth is right [m], [rad]."""
PLACE_XY, PLACE_THETA = 0.05, math.radians(10)
"""Farther than this from the truth it is another place [m], [rad]."""
HELD = 1.0
"""For so long, to count [s]."""

Mask = NDArray[np.bool_]


def errors(run: Run, poses: Array) -> tuple[Array, Array]:
    """Distances (n,) [m] and turns (n,) [rad] from the truth to poses (n, 3) of a run."""
    offset = poses - run.truth
    return np.linalg.norm(offset[:, :2], axis=1), wrap_angle(offset[:, 2])


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
    first = first_held(stamps, right)
    return math.inf if first is None else float(stamps[first] - stamps[0])


def first_held(stamps: Array, some: Mask) -> int | None:
    """The first of n pictures from which on something holds for a second; None if it never does.

    Args:
        stamps: (n,) [s].
        some: (n,) whether it holds.
    """
    for first in np.flatnonzero(some & ~np.concatenate([[False], some[:-1]])):
        until = int(np.searchsorted(stamps, stamps[first] + HELD - 1e-9))
        if until < len(stamps) and some[first : until + 1].all():
            return int(first)
    return None


def in_place(distances: Array, turns: Array) -> Mask:
    """Whether estimates (n,) are about the truth, by distance [m] and turn [rad]."""
    near: Mask = (distances < PLACE_XY) & (np.abs(turns) < PLACE_THETA)
    return near


def right_to_the_end(stamps: Array, right: Mask) -> bool:
    """Whether it was once right for a second, and at each picture (n,) from then on."""
    first = first_held(stamps, right)
    return first is not None and bool(right[first:].all())


def lost_again(stamps: Array, right: Mask, certain: Mask) -> bool:
    """Whether it was right and certain for a second, and wrong at a picture (n,) after that."""
    first = first_held(stamps, right & certain)
    return first is not None and not right[first:].all()


def steady_error(run: Run) -> float:
    """Root mean square of the distances [m] once it is settled; nan if it never is."""
    late = settled(run)
    return rms(errors(run, run.estimate)[0][late]) if late.any() else math.nan


def settled(run: Run) -> Array:
    """Which pictures (n,) come a second or more after the estimate became right; none if never."""
    seconds = time_to_converge(run.stamps, *errors(run, run.estimate))
    late: Array = run.stamps >= run.stamps[0] + seconds + HELD
    return late
