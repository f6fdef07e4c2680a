"""Stamps of poses in a file that has none."""

from __future__ import annotations

import numpy as np

from app.features.lab.trajectories.text_file import rows_of_numbers
from app.trajectories.trajectory import TrajectoryError
from robot.geometry import Array

UNDERSTOOD = "understood:"
"""Start of a note on what was taken for granted, as the unit of stamps."""
TIMES = "times.txt"
"""KITTI's file of stamps, one a line [s], beside the poses."""
STEP = 0.1
"""Time between KITTI's poses [s]."""


def stamps_of(count: int, source: str, times: str | None) -> tuple[Array, tuple[str, ...]]:
    """Return stamps (n,) [s] of poses that have none, and a note if they are counted.

    Args:
        times: the text of a file of stamps, one a line [s]; None counts in steps of 0.1 s, as
            KITTI's camera does.

    Raises:
        TrajectoryError: there is another number of stamps.
    """
    if times is None:
        note = f"{UNDERSTOOD} {source} has no stamps ({TIMES} beside it would): a pose each "
        return STEP * np.arange(count, dtype=np.float64), (f"{note}{STEP:g} s",)
    _, stamped = rows_of_numbers(times, TIMES, "stamp")
    stamps = np.array(stamped, dtype=np.float64).ravel()
    if len(stamps) != count:
        raise TrajectoryError(f"{source} has {count} poses, and {TIMES} {len(stamps)}")
    return stamps, ()
