"""Estimate the offset between the clocks of an estimate and of the truth, from their motions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from app.lab.trajectories.motion_profile import MotionProfile, correlations, in_gap, motion_profile
from app.lab.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

OVERLAP = 0.5
"""The overlap must be at least this part of the shorter trajectory."""
AS_GOOD, AS_LONG = 0.05, 0.1
"""A peak counts as well if its correlation and overlap are less than this below the best ones."""
REFINED_WITHIN = 0.05
"""Positions may move the peak of the correlation by up to this [s]; else they are ignored."""
NOISE = 0.1
"""Errors above the path length in this time [s] are drift or jumps: positions are ignored."""
BETWEEN = 0.2
"""Time between the poses that the mean speed is computed from [s]."""
USUALLY = 80
"""Percentile of the speeds that scales are compared by: a robot may stand, an estimate may jump."""
OTHER_SIZE = 1.5
"""If speeds differ by this factor, the estimate has another unit, or none (a single camera)."""
PIECE = 20.0
"""Positions are compared in pieces of this length [s], each aligned alone, as odometry drifts."""
POSES_COMPARED = 20_000
PEAKS = 16
"""Number of the highest peaks that are compared."""
SAME_RUN = 0.8
"""Two trajectories with a smaller correlation are of different runs.

Trajectories of one run have 0.95 and more (wheel odometry against Vicon; noise of 5 mm). Random
paths reach by chance 0.45 in 40 s and 0.72 in 20 s, but 0.85 in 10 s: paths that short may look
alike.
"""


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """The time to add to the estimate's stamps to get the truth's clock."""

    seconds: float
    """[s]."""
    correlation: float
    """Of speed and turn rate at this offset, in [-1, 1]; low if they are not of one run."""
    overlap: float
    """Part of the shorter trajectory that is in both, in [0, 1]."""
    error: float
    """Root mean square distance [m] after aligning the pieces."""


def estimate_clock_offset(
    truth: Trajectory, estimate: Trajectory, search: float | None = None
) -> ClockOffset:
    """Find the offset between the clocks of two trajectories of one run.

    Speeds and turn rates do not depend on the choice of frames. They are correlated over all
    offsets at which half of the shorter trajectory overlaps. A path that is driven twice gives
    several peaks that are equally good: then those with the largest overlap count, and of these
    the one with the smallest error of position. The minimum of that error, with the truth
    interpolated, refines the offset unless the estimate drifts or jumps. If either trajectory is
    planar, the other is seen from above. With noise of s [m] in n poses at speed v the offset
    errs by about s / (v sqrt(n)) [s]. An estimate of another scale, such as from a single camera,
    is first scaled to the truth.

    Args:
        truth: with any clock.
        estimate: with any clock.
        search: largest offset [s]; None means any.

    Raises:
        TrajectoryError: a trajectory is too short or too long, or no offset is in reach.
    """
    to_planar = truth.planar or estimate.planar
    true, result = motion_profile(truth, to_planar), motion_profile(estimate, to_planar)
    size = _size(true, result)
    offsets, alike, overlap = correlations(true, result.scaled(size))
    estimate = replace(estimate, positions=size * estimate.positions, lines=None)
    reached = overlap >= OVERLAP
    if search is not None:
        reached &= np.abs(offsets) <= search
    if not reached.any():
        within = "" if search is None else f" with clocks up to {search:g} s apart"
        raise TrajectoryError(
            f"{truth.name} and {estimate.name} overlap too little in time{within}; "
            f"valid is at least {OVERLAP:.0%} of the shorter one"
        )
    alike = np.where(reached, alike, -2.0)
    likely = []
    for peak in _peaks(alike, overlap):
        offset, error = _refined(truth, estimate, _top(offsets, alike, int(peak)))
        likely.append(ClockOffset(offset, float(alike[peak]), float(overlap[peak]), error))
    return min(likely, key=lambda item: item.error)


def require_same_run(
    truth: Trajectory, estimate: Trajectory, search: float | None = None
) -> ClockOffset:
    """Return the clock offset of two trajectories that must be of one run.

    Two runs of the same driving program move alike and cannot be told apart.

    Raises:
        TrajectoryError: the trajectories move differently, or there is no offset.
    """
    offset = estimate_clock_offset(truth, estimate, search)
    if offset.correlation < SAME_RUN:
        raise TrajectoryError(
            f"{truth.name} is of another run than {estimate.name}: whatever the clocks, speed and "
            f"turn rate correlate by {offset.correlation:.2f}; valid is {SAME_RUN:g} and more"
        )
    return offset


def _peaks(alike: Array, overlap: Array) -> NDArray[np.int64]:
    """Return the peaks of the correlation about as good as the best, with about its overlap."""
    padded = np.concatenate([[-2.0], alike, [-2.0]])
    peaks = np.flatnonzero((alike >= padded[:-2]) & (alike > padded[2:]) & (alike > -2))
    peaks = peaks[alike[peaks] >= alike[peaks].max() - AS_GOOD]
    peaks = peaks[overlap[peaks] >= overlap[peaks].max() - AS_LONG]
    highest: NDArray[np.int64] = peaks[np.argsort(-alike[peaks], kind="stable")[:PEAKS]]
    return highest


def _top(offsets: Array, alike: Array, peak: int) -> float:
    """Return the maximum [s] of the parabola through a peak and its neighbours."""
    if not 0 < peak < len(alike) - 1 or min(alike[peak - 1], alike[peak + 1]) <= -2:
        return float(offsets[peak])
    before, top, after = alike[peak - 1 : peak + 2]
    part = (before - after) / (2 * (before - 2 * top + after))
    return float(offsets[peak] + part * (offsets[1] - offsets[0]))


def _refined(truth: Trajectory, estimate: Trajectory, offset: float) -> tuple[float, float]:
    """Return the offset [s] near another one with the least position error, and that error [m]."""
    stamps, positions = _compared(truth, estimate, offset)
    if len(stamps) < 3:
        return offset, np.inf
    pieces = _Pieces.of(stamps, positions)

    def error(change: float) -> float:
        asked = stamps + change
        return pieces.error(
            np.column_stack([np.interp(asked, truth.stamps, axis) for axis in truth.positions.T])
        )

    best = minimize_scalar(
        error,
        bounds=(-REFINED_WITHIN, REFINED_WITHIN),
        method="bounded",
        options={"xatol": 1e-6},
    )
    if abs(best.x) > 0.98 * REFINED_WITHIN or best.fun > NOISE * _speed(truth):
        return offset, error(0.0)
    return offset + float(best.x), float(best.fun)


def _size(true: MotionProfile, result: MotionProfile) -> float:
    """Return the factor that scales an estimate to the truth; 1 unless the scales differ much."""
    usual, theirs = (
        float(np.percentile(item.channels[0, item.known], USUALLY)) if item.known.any() else 0.0
        for item in (true, result)
    )
    if min(usual, theirs) <= 0 or max(usual / theirs, theirs / usual) < OTHER_SIZE:
        return 1.0
    return usual / theirs


def _speed(trajectory: Trajectory) -> float:
    """Return the mean speed [m/s], from poses far enough apart that noise adds little."""
    asked = trajectory.stamps[0] + np.arange(0.0, trajectory.duration, BETWEEN)
    few = np.searchsorted(trajectory.stamps, asked)
    way = np.linalg.norm(np.diff(trajectory.positions[few], axis=0), axis=1)
    return float(np.sum(way)) / trajectory.duration


def _compared(truth: Trajectory, estimate: Trajectory, offset: float) -> tuple[Array, Array]:
    """Return stamps (n,) on the truth's clock and positions (n, 3) of the estimate.

    Only poses count at which the truth is known.
    """
    stamps = estimate.stamps + offset
    ends = (stamps - REFINED_WITHIN, stamps, stamps + REFINED_WITHIN)
    known = np.flatnonzero(~np.any([in_gap(truth, end) for end in ends], axis=0))
    known = known[:: len(known) // POSES_COMPARED + 1]
    return stamps[known], estimate.positions[known]


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Positions in pieces, each relative to its own mean."""

    starts: NDArray[np.int64]
    lengths: NDArray[np.int64]
    centred: Array
    """(n, 3) [m]."""

    @classmethod
    def of(cls, stamps: Array, positions: Array) -> _Pieces:
        """Cut positions into pieces of equal duration, at least PIECE unless there is only one."""
        elapsed = stamps - stamps[0]
        count = max(int(elapsed[-1] / PIECE), 1)
        piece = np.minimum((elapsed * count / elapsed[-1]).astype(np.int64), count - 1)
        starts = np.flatnonzero(np.diff(piece, prepend=-1))
        lengths = np.diff(np.append(starts, len(stamps)))
        return cls(starts, lengths, _about_middles(positions, starts, lengths))

    def error(self, truth: Array) -> float:
        """Return the rms distance [m] to positions (n, 3) after aligning each piece (Umeyama)."""
        other = _about_middles(truth, self.starts, self.lengths)
        cross = np.add.reduceat(other[:, :, None] * self.centred[:, None, :], self.starts)
        values = np.linalg.svd(cross, compute_uv=False)
        # A reflection is not a rigid motion.
        values[:, 2] *= np.where(np.linalg.det(cross) < 0, -1, 1)
        squares = np.sum(other**2) + np.sum(self.centred**2) - 2 * np.sum(values)
        return float(np.sqrt(max(squares, 0.0) / len(truth)))


def _about_middles(
    positions: Array, starts: NDArray[np.int64], lengths: NDArray[np.int64]
) -> Array:
    middles = np.add.reduceat(positions, starts) / lengths[:, None]
    centred: Array = positions - np.repeat(middles, lengths, axis=0)
    return centred
