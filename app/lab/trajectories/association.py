"""Bring two trajectories to the same stamps, by the nearest pose or by interpolation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

from app.lab.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

FEWEST = 3
"""Smallest useful number of pairs."""


def associate(
    truth: Trajectory, estimate: Trajectory, max_difference: float = 0.01
) -> tuple[Trajectory, Trajectory]:
    """Pair poses of nearly the same stamp; return them as two trajectories of equal length.

    For each stamp of the trajectory with fewer poses (if equal: the estimate), the nearest pose of
    the other one is taken; of two equally near poses, the earlier one. The pair is dropped if the
    stamps differ by more than the largest difference. One pose of the longer trajectory may be in
    several pairs. Both results have the stamps of the shorter one. These are the pairs of evo and
    of the tools of the TUM benchmark, so that the figures agree.

    Args:
        estimate: the trajectory to judge, on the same clock.
        max_difference: largest difference of two stamps [s].

    Raises:
        TrajectoryError: there are fewer than three pairs; names files and their times.
    """
    truth_asks = len(estimate) > len(truth)
    asking, asked = (truth, estimate) if truth_asks else (estimate, truth)
    nearest, result = _nearest(asking.stamps, asked.stamps, max_difference)
    if np.count_nonzero(result) < FEWEST:
        raise TrajectoryError(_too_few(truth, estimate, int(np.count_nonzero(result))))
    these, those = (
        asking.selected(result),
        _with_stamps(asked, nearest[result], asking.stamps[result]),
    )
    return (these, those) if truth_asks else (those, these)


def _nearest(
    stamps: Array, among: Array, max_difference: float
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return for each stamp the index (n,) of the nearest one, and whether it is near enough."""
    after = np.minimum(np.searchsorted(among, stamps, side="right"), len(among) - 1)
    to_after = among[after] - stamps
    to_before = np.where(after > 0, stamps - among[after - 1], np.inf)
    take_after = (to_after <= max_difference) & (to_after < to_before)
    take_before = (to_before <= max_difference) & ~take_after & (to_before <= to_after)
    inside = (stamps >= among[0] - max_difference) & (stamps <= among[-1] + max_difference)
    return np.where(take_after, after, after - 1), inside & (take_after | take_before)


def _with_stamps(trajectory: Trajectory, indices: NDArray[np.int64], stamps: Array) -> Trajectory:
    """Return the poses at indices, with other stamps, some of which may repeat."""
    return Trajectory(
        stamps,
        trajectory.positions[indices],
        trajectory.quaternions[indices],
        trajectory.source,
        trajectory.notes,
        repeats=True,
    )


def at(
    trajectory: Trajectory, stamps: ArrayLike, max_gap: float = 0.2
) -> tuple[Trajectory, NDArray[np.bool_]]:
    """Interpolate a trajectory: positions along straight lines, rotations by the shorter way.

    Args:
        stamps: rising stamps (n,) [s], on its clock.
        max_gap: longest time between two poses [s] over which to interpolate.

    Returns:
        The poses at those stamps where they are known, and which stamps those are (n,).

    Raises:
        TrajectoryError: the poses are known at fewer than two stamps; names the times.
    """
    trajectory = trajectory.without_repeats()
    asked = np.asarray(stamps, dtype=np.float64).ravel()
    known = trajectory.stamps
    before = np.clip(np.searchsorted(known, asked, side="right") - 1, 0, len(known) - 2)
    inside = (asked >= known[0]) & (asked <= known[-1])
    hit = (asked == known[before]) | (asked == known[before + 1])
    given = inside & (hit | (known[before + 1] - known[before] <= max_gap))
    if np.count_nonzero(given) < 2:
        raise TrajectoryError(
            f"{_times(trajectory)} has poses at {np.count_nonzero(given)} of {len(asked)} stamps, "
            f"with gaps up to {max_gap:g} s; valid are 2 and more"
        )
    between = Slerp(known, Rotation.from_quat(trajectory.quaternions))
    positions = [np.interp(asked[given], known, axis) for axis in trajectory.positions.T]
    poses = Trajectory(
        asked[given],
        np.column_stack(positions),
        between(asked[given]).as_quat(),
        trajectory.source,
        trajectory.notes,
    )
    return poses, given


def _too_few(truth: Trajectory, estimate: Trajectory, pairs: int) -> str:
    ranges = f"{_times(truth)} and {_times(estimate)}"
    apart = truth.stamps[-1] < estimate.stamps[0] or estimate.stamps[-1] < truth.stamps[0]
    if apart:
        return f"{ranges} do not overlap in time; valid are stamps of one clock"
    return f"{ranges} have {pairs or 'no'} pairs of poses at one time; valid are {FEWEST} and more"


def _times(trajectory: Trajectory) -> str:
    first, last = trajectory.stamps[[0, -1]]
    return f"{trajectory.name} (from {first:.3f} to {last:.3f} s)"
