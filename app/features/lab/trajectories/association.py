"""Bring two trajectories to the same stamps, by the nearest pose or by interpolation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from app.features.lab.trajectories.motion_profile import in_gap, longest_step
from app.features.lab.trajectories.time_shift import Course
from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

FEWEST = 3
"""Smallest useful number of pairs."""
NEAREST = 0.01
"""Usual largest difference of two stamps of a pair [s], that of evo and of the TUM benchmark."""
MOST = 0.5
"""If fewer than this part of the poses have a pair by their stamps, the truth is interpolated."""


@dataclass(frozen=True)
class Pairs:
    """Poses of a truth and an estimate at the same stamps."""

    truth: Trajectory
    estimate: Trajectory
    judged: float
    """Part of the estimate's time that they cover, in [0, 1]."""
    interpolation_error: float | None = None
    """About how far the interpolated truth is off [m]; None if no pose was interpolated."""

    def __len__(self) -> int:
        return len(self.truth)


def pairs_of(truth: Trajectory, estimate: Trajectory, max_difference: float | None = None) -> Pairs:
    """Pair the poses of the nearest stamps, or interpolate the truth if few stamps meet.

    Args:
        estimate: the trajectory to judge, on the same clock.
        max_difference: largest difference of two stamps of a pair [s]; None means 10 ms, and that
            the truth is interpolated at the estimate's stamps if most would find no pair.

    Raises:
        TrajectoryError: there are fewer than three pairs.
    """
    largest = NEAREST if max_difference is None else max_difference
    if max_difference is None:
        asked = ~in_gap(truth, estimate.stamps), ~in_gap(estimate, truth.stamps)
        possible = min(np.count_nonzero(known) for known in asked)
        few, many = sorted((truth, estimate), key=len)
        met = np.count_nonzero(_nearest(few.stamps, many.stamps, largest)[1])
        if possible >= FEWEST and met < MOST * possible:
            return _interpolated(truth, estimate.selected(asked[0]), estimate.duration)
    true, result = associate(truth, estimate, largest)
    return Pairs(true, result, _covered(result) / estimate.duration)


def _interpolated(truth: Trajectory, estimate: Trajectory, duration: float) -> Pairs:
    """Return the pairs at the stamps of an estimate, at all of which the truth is known.

    Cubic splines go through the truth's positions: straight lines cut the corners of a path, by
    8 mm where a robot's truth has a pose a second. The estimate is not interpolated, as the mean
    of two of its poses has less noise than they have.
    """
    course = Course.of(truth)
    stamps = estimate.stamps
    if truth.planar:
        poses = np.column_stack([course.places(stamps), course.headings(stamps)])
        true = Trajectory.of_poses(stamps, poses, truth.source, truth.notes, repeats=True)
    else:
        between = Slerp(course.truth.stamps, Rotation.from_quat(course.truth.quaternions))
        turns = between(stamps).as_quat()
        true = Trajectory(
            stamps, course.places(stamps), turns, truth.source, truth.notes, repeats=True
        )
    # Where the path bends sharply, half of the poses err four times as much; else sixteen times.
    skipped = slice(1, -1, 2)
    misses = course.coarser().places(course.truth.stamps[skipped]) - course.places(
        course.truth.stamps[skipped]
    )
    error = float(np.sqrt(np.mean(np.sum(misses**2, axis=1)))) / 4
    return Pairs(true, estimate, _covered(estimate) / duration, error)


def _covered(trajectory: Trajectory) -> float:
    """Return the time [s] that a trajectory covers without its gaps."""
    steps = np.diff(trajectory.stamps)
    return float(np.sum(steps[steps <= longest_step(trajectory)]))


def associate(
    truth: Trajectory, estimate: Trajectory, max_difference: float = NEAREST
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
        pairs = int(np.count_nonzero(result))
        raise TrajectoryError(_too_few(truth, estimate, pairs, max_difference))
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


def _too_few(truth: Trajectory, estimate: Trajectory, pairs: int, largest: float) -> str:
    ranges = f"{_times(truth)} and {_times(estimate)}"
    apart = truth.stamps[-1] < estimate.stamps[0] or estimate.stamps[-1] < truth.stamps[0]
    if apart:
        return f"{ranges} do not overlap in time; valid are stamps of one clock"
    return (
        f"{ranges} have {pairs or 'no'} pairs of poses at one time, within {largest:g} s; "
        f"valid are {FEWEST} and more"
    )


def _times(trajectory: Trajectory) -> str:
    first, last = trajectory.stamps[[0, -1]]
    return f"{trajectory.name} (from {first:.3f} to {last:.3f} s)"
