"""Stamps of a file that several poses share: digits were lost, or it has several frames."""

from __future__ import annotations

import numpy as np

from app.trajectories.trajectory import Trajectory, TrajectoryError

SHARED = 0.5
"""A few repeated stamps are usual; from this part of the poses on they are not."""
LEAST_POSES = 10
"""Fewer poses tell nothing."""
APART = 3.0
"""Poses at one stamp are of several frames if they are this many times as far apart as each frame
moves from stamp to stamp ..."""
APART_M = 0.02
"""... and at least this far [m]."""


def doubt_of_stamps(trajectory: Trajectory) -> str | None:
    """Return what people should know if most poses share their stamps with others.

    Raises:
        TrajectoryError: the stamps have lost digits, so that poses one after another have the same.
    """
    stamps, places = trajectory.stamps, trajectory.positions
    first = np.flatnonzero(np.append(True, np.diff(stamps) > 0))
    if len(stamps) < LEAST_POSES or len(first) > (1 - SHARED) * len(stamps):
        return None
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    within = np.delete(steps, first[1:] - 1)
    onward = np.linalg.norm(np.diff(places[first], axis=0), axis=1)
    apart = float(np.median(within))
    if len(onward) and apart > max(APART * float(np.median(onward)), APART_M):
        return (
            f"{trajectory.name} has {len(stamps) / len(first):.1f} poses a stamp, {apart:.2f} m "
            "apart: are several frames or bodies in one file? valid is one"
        )
    if len(onward) and (not within.any() or float(np.median(onward)) <= apart):
        return None  # the same pose, written several times, or too little motion to tell
    raise TrajectoryError(
        f"{trajectory.name} has {len(stamps)} poses at only {len(first)} stamps: were they written "
        "with too few digits (%g) or as float32? valid are such as 1700000000.123456"
    )
