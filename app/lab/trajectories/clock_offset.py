"""How far the clock of an estimate is from the truth's, from how both move."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from app.lab.trajectories.motion_profile import MotionProfile, correlations, in_gap, motion_profile
from app.lab.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

OVERLAP = 0.5
"""At least this part of the shorter one must be in both."""
AS_GOOD, AS_LONG = 0.05, 0.1
"""Peaks this little below the best correlation, and overlap, are as good."""
REFINED_WITHIN = 0.05
"""Positions move the peak of the correlation by less than this [s], or are not believed."""
NOISE = 0.1
"""Errors larger than the way in this time [s] are drift and jumps: positions are not believed."""
BETWEEN = 0.2
"""Between poses of which a speed is taken [s]."""
USUALLY = 80
"""Percentile of the speeds by which sizes are compared: a robot may stand, and an estimate jump."""
OTHER_SIZE = 1.5
"""What is so many times as fast has another unit or, as of a single camera, none."""
PIECE = 20.0
"""Positions are compared in pieces of this length [s], each aligned alone, as odometry drifts."""
POSES_COMPARED = 20_000
PEAKS = 16
"""So many of the highest are looked at."""
SAME_RUN = 0.8
"""Two trajectories that correlate less are of two runs.

Those of one run do by 0.95 and more (wheel odometry against Vicon; noise of 5 mm). Random paths
reach by chance 0.45 in 40 s and 0.72 in 20 s, but 0.85 in 10 s: so short ones may look alike.
"""


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """What must be added to the estimate's stamps to be on the truth's clock."""

    seconds: float
    """[s]."""
    correlation: float
    """Of speed and turn rate at this offset, in [-1, 1]; low if they are not of one run."""
    overlap: float
    """Which part of the shorter one is in both, in [0, 1]."""
    error: float
    """Root mean square of distances [m] after aligning the pieces."""


def estimate_clock_offset(
    truth: Trajectory, estimate: Trajectory, search: float | None = None
) -> ClockOffset:
    """Find the offset between the clocks of two trajectories of one run.

    Speeds and turn rates, which no choice of frames changes, are correlated over all offsets at
    which half of the shorter one overlaps. Of peaks that are as good, as a path that is driven
    twice has them, those with the largest overlap count, and of these the one with the least error
    of position; its minimum, with truth between its poses, refines the offset unless the estimate
    drifts or jumps. If either is planar the other is taken from above. Noise of s [m] in n poses
    at speed v leaves some s / (v sqrt(n)) [s]. An estimate of another size, as a single camera
    makes it, is brought to the truth's first.

    Args:
        truth: with any clock.
        estimate: with any clock.
        search: largest offset [s]; None looks everywhere.

    Raises:
        TrajectoryError: one is too short or too long, or no offset is in reach.
    """
    from_above = truth.planar or estimate.planar
    true, result = motion_profile(truth, from_above), motion_profile(estimate, from_above)
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
    """The clock offset of two trajectories that must be of one run.

    Two runs of one program move alike and cannot be told apart.

    Raises:
        TrajectoryError: they move differently, or there is no offset.
    """
    offset = estimate_clock_offset(truth, estimate, search)
    if offset.correlation < SAME_RUN:
        raise TrajectoryError(
            f"{truth.name} is of another run than {estimate.name}: whatever the clocks, speed and "
            f"turn rate correlate by {offset.correlation:.2f}; valid is {SAME_RUN:g} and more"
        )
    return offset


def _peaks(alike: Array, overlap: Array) -> NDArray[np.int64]:
    """Peaks of the correlation that are as good as the best, and overlap as much."""
    padded = np.concatenate([[-2.0], alike, [-2.0]])
    peaks = np.flatnonzero((alike >= padded[:-2]) & (alike > padded[2:]) & (alike > -2))
    peaks = peaks[alike[peaks] >= alike[peaks].max() - AS_GOOD]
    peaks = peaks[overlap[peaks] >= overlap[peaks].max() - AS_LONG]
    highest: NDArray[np.int64] = peaks[np.argsort(-alike[peaks], kind="stable")[:PEAKS]]
    return highest


def _top(offsets: Array, alike: Array, peak: int) -> float:
    """Where the parabola through a peak and its neighbours is highest [s]."""
    if not 0 < peak < len(alike) - 1 or min(alike[peak - 1], alike[peak + 1]) <= -2:
        return float(offsets[peak])
    before, top, after = alike[peak - 1 : peak + 2]
    part = (before - after) / (2 * (before - 2 * top + after))
    return float(offsets[peak] + part * (offsets[1] - offsets[0]))


def _refined(truth: Trajectory, estimate: Trajectory, offset: float) -> tuple[float, float]:
    """The offset [s] near another one with the least error [m] of position, and that error."""
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
    """What an estimate is to be multiplied by; 1 unless it is of quite another size."""
    usual, theirs = (
        float(np.percentile(item.channels[0, item.known], USUALLY)) if item.known.any() else 0.0
        for item in (true, result)
    )
    if min(usual, theirs) <= 0 or max(usual / theirs, theirs / usual) < OTHER_SIZE:
        return 1.0
    return usual / theirs


def _speed(trajectory: Trajectory) -> float:
    """Length of the way by its duration [m/s], by poses so far apart that noise adds little."""
    asked = trajectory.stamps[0] + np.arange(0.0, trajectory.duration, BETWEEN)
    few = np.searchsorted(trajectory.stamps, asked)
    way = np.linalg.norm(np.diff(trajectory.positions[few], axis=0), axis=1)
    return float(np.sum(way)) / trajectory.duration


def _compared(truth: Trajectory, estimate: Trajectory, offset: float) -> tuple[Array, Array]:
    """Stamps (n,) on the truth's clock and positions (n, 3) of the estimate within the truth."""
    stamps = estimate.stamps + offset
    ends = (stamps - REFINED_WITHIN, stamps, stamps + REFINED_WITHIN)
    known = np.flatnonzero(~np.any([in_gap(truth, end) for end in ends], axis=0))
    known = known[:: len(known) // POSES_COMPARED + 1]
    return stamps[known], estimate.positions[known]


@dataclass(frozen=True, eq=False)
class _Pieces:
    """Positions in pieces, each about its own middle."""

    starts: NDArray[np.int64]
    lengths: NDArray[np.int64]
    centred: Array
    """(n, 3) [m]."""

    @classmethod
    def of(cls, stamps: Array, positions: Array) -> _Pieces:
        """Pieces of equal duration, none much shorter than PIECE."""
        elapsed = stamps - stamps[0]
        count = max(int(elapsed[-1] / PIECE), 1)
        piece = np.minimum((elapsed * count / elapsed[-1]).astype(np.int64), count - 1)
        starts = np.flatnonzero(np.diff(piece, prepend=-1))
        lengths = np.diff(np.append(starts, len(stamps)))
        return cls(starts, lengths, _about_middles(positions, starts, lengths))

    def error(self, truth: Array) -> float:
        """Root mean square distance [m] to positions (n, 3) after aligning each piece (Umeyama)."""
        other = _about_middles(truth, self.starts, self.lengths)
        cross = np.add.reduceat(other[:, :, None] * self.centred[:, None, :], self.starts)
        values = np.linalg.svd(cross, compute_uv=False)
        # A reflection is no motion.
        values[:, 2] *= np.where(np.linalg.det(cross) < 0, -1, 1)
        squares = np.sum(other**2) + np.sum(self.centred**2) - 2 * np.sum(values)
        return float(np.sqrt(max(squares, 0.0) / len(truth)))


def _about_middles(
    positions: Array, starts: NDArray[np.int64], lengths: NDArray[np.int64]
) -> Array:
    middles = np.add.reduceat(positions, starts) / lengths[:, None]
    centred: Array = positions - np.repeat(middles, lengths, axis=0)
    return centred
