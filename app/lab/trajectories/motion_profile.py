"""How something moves, apart from where: speed and turn rate, whatever frames they were seen in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.ndimage import gaussian_filter1d

from app.lab.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

STEP = 0.02
"""Between samples [s]."""
SMOOTHING = 0.15
"""Standard deviation [s] of the Gaussian that takes the noise of single poses away."""
SHORTEST, LONGEST = 2.0, 20_000.0
"""How long a trajectory lasts of which this can be said [s]."""
GAP = 0.5
"""Between poses farther apart than this [s], and than is usual in the file, nothing is known."""
LEVERS = (0.05, 1.0)
"""Bounds of the length [m] that makes a turn rate comparable with a speed."""
QUIET = 0.05
"""Where less than this part of the usual variance is left nothing correlates."""


@dataclass(frozen=True, eq=False)
class MotionProfile:
    """Speed and turn rate at even steps from a start on."""

    start: float
    """[s]."""
    channels: Array
    """(2, n): speed [m/s], turn rate [rad/s]; with a sign if it is seen from above."""
    known: NDArray[np.bool_]
    """(n,): not within a gap."""

    def scaled(self, size: float) -> MotionProfile:
        """Of a path that is so many times as large."""
        return replace(self, channels=self.channels * [[size], [1.0]])


def motion_profile(trajectory: Trajectory, from_above: bool) -> MotionProfile:
    """Speed and turn rate of a trajectory, smoothed.

    Args:
        trajectory: whose.
        from_above: turn rate about z with its sign; else its magnitude about any axis.

    Raises:
        TrajectoryError: it is too short or too long.
    """
    if not SHORTEST <= trajectory.duration <= LONGEST:
        raise TrajectoryError(
            f"{trajectory.name} lasts {trajectory.duration:.4g} s, too "
            f"{'short' if trajectory.duration < SHORTEST else 'long'} to compare how it moves; "
            f"valid are {SHORTEST:g} to {LONGEST:g} s"
        )
    start, stamps = trajectory.stamps[0], trajectory.stamps
    grid = start + STEP * np.arange(int(trajectory.duration / STEP) + 1)
    speed = np.linalg.norm(_rates(grid, stamps, trajectory.positions), axis=1)
    if from_above:
        turn = _rates(grid, stamps, np.unwrap(trajectory.poses[:, 2])[:, None])[:, 0]
    else:
        # Of a unit quaternion the rate is half the turn rate.
        turn = 2 * np.linalg.norm(_rates(grid, stamps, _continuous(trajectory)), axis=1)
    return MotionProfile(start, np.stack([speed, turn]), ~in_gap(trajectory, grid))


def in_gap(trajectory: Trajectory, stamps: Array) -> NDArray[np.bool_]:
    """Whether stamps (n,) are off the trajectory's end or in a gap of it."""
    known = trajectory.stamps
    gaps = np.diff(known)
    longest = max(GAP, 3 * float(np.median(gaps)))
    before = np.clip(np.searchsorted(known, stamps, side="right") - 1, 0, len(gaps) - 1)
    missing: NDArray[np.bool_] = (
        (stamps < known[0]) | (stamps > known[-1]) | (gaps[before] > longest)
    )
    return missing


def _rates(grid: Array, stamps: Array, values: Array) -> Array:
    """Rates (m, k) of change of values (n, k), smoothed."""
    sampled = np.column_stack([np.interp(grid, stamps, column) for column in values.T])
    rates: Array = gaussian_filter1d(sampled, SMOOTHING / STEP, axis=0, order=1) / STEP
    return rates


def _continuous(trajectory: Trajectory) -> Array:
    """Quaternions (n, 4), each with the sign that is nearer to the one before."""
    quaternions = trajectory.quaternions
    along = np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1])
    signs = np.cumprod(np.append(1.0, np.where(along < 0, -1.0, 1.0)))
    continuous: Array = quaternions * signs[:, None]
    return continuous


def correlations(truth: MotionProfile, estimate: MotionProfile) -> tuple[Array, Array, Array]:
    """How alike two profiles are at each lag at which they overlap.

    The correlation of both channels together, each less its mean where they overlap; turn rates
    count with the length at which they are as large as speeds.

    Returns:
        What to add to the estimate's stamps [s], the correlation in [-1, 1] and how much of what
        the shorter one knows overlaps, in [0, 1], each (m,).
    """
    speed, turn = np.sqrt(np.mean(np.square(truth.channels), axis=1))
    lever = np.array([[1.0], [np.clip(speed / max(turn, 1e-9), *LEVERS)]])
    ours, theirs = _centred(truth, lever), _centred(_clipped(estimate, truth), lever)
    n, m = ours.shape[1], theirs.shape[1]
    lags, size = np.arange(1 - m, n), next_fast_len(n + m, real=True)

    def summed(a: Array, b: Array) -> Array:
        """Sums of products (2, k) at all lags."""
        products: Array = irfft(rfft(a, size) * np.conj(rfft(b, size)), size)[..., lags % size]
        return products

    known, also_known = truth.known.astype(np.float64), estimate.known.astype(np.float64)
    both = np.round(summed(known, also_known))
    count = np.maximum(both, 1)
    sums, their_sums = summed(ours, also_known), summed(known, theirs)
    product = summed(ours, theirs) - sums * their_sums / count
    variance = (summed(ours**2, also_known) - sums**2 / count).sum(axis=0)
    their_variance = (summed(known, theirs**2) - their_sums**2 / count).sum(axis=0)
    usual = np.sqrt(np.sum(ours**2) / max(known.sum(), 1) * np.sum(theirs**2))
    floor = QUIET * usual / np.sqrt(max(also_known.sum(), 1)) * count
    scale = np.maximum(np.sqrt(np.maximum(variance, 0) * np.maximum(their_variance, 0)), floor)
    alike = product.sum(axis=0) / np.maximum(scale, 1e-30)
    overlap = both / max(min(known.sum(), also_known.sum()), 1)
    return truth.start - estimate.start + lags * STEP, np.clip(alike, -1, 1), overlap


def _clipped(profile: MotionProfile, target: MotionProfile) -> MotionProfile:
    """Where an estimate jumps it is faster than anything that moves; that would hide the rest."""
    slowest, fastest = target.channels.min(axis=1), target.channels.max(axis=1)
    within = np.clip(profile.channels, slowest[:, None], fastest[:, None])
    return replace(profile, channels=within)


def _centred(profile: MotionProfile, lever: Array) -> Array:
    """Channels (2, n) about their means, zero where nothing is known."""
    known = profile.known
    if not known.any():
        return np.zeros_like(profile.channels)
    means = profile.channels[:, known].mean(axis=1, keepdims=True)
    centred: Array = np.where(known, profile.channels - means, 0.0) * lever
    return centred
