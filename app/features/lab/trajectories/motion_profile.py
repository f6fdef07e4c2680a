"""Speed and turn rate of a trajectory over time; they do not depend on the choice of frames."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft
from scipy.ndimage import gaussian_filter1d

from app.trajectories.trajectory import Trajectory, TrajectoryError
from robot.geometry import Array

STEP = 0.02
"""Time between samples [s]."""
SMOOTHINGS = (0.15, 0.6)
"""Standard deviations [s] of the Gaussians that remove the noise of single poses."""
SHORTEST, LONGEST = 2.0, 20_000.0
"""Shortest and longest duration of a trajectory that can be profiled [s]."""
GAP = 0.5
"""Poses farther apart than this [s], and than three times the file's median, leave a gap."""
LEVERS = (0.05, 1.0)
"""Bounds of the length [m] that turns a turn rate into a comparable speed."""
QUIET = 0.05
"""Overlaps with less than this part of the usual variance get a low correlation."""


@dataclass(frozen=True, eq=False)
class MotionProfile:
    """Speed and turn rate at even steps after a start."""

    start: float
    """[s]."""
    channels: Array
    """(2, n): speed [m/s], turn rate [rad/s]; the turn rate has a sign if seen from above."""
    known: NDArray[np.bool_]
    """(n,): whether the sample is outside of gaps."""

    def scaled(self, size: float) -> MotionProfile:
        """Return the profile of the path scaled by a factor."""
        return replace(self, channels=self.channels * [[size], [1.0]])


def motion_profile(
    trajectory: Trajectory, to_planar: bool, smoothing: float = SMOOTHINGS[0]
) -> MotionProfile:
    """Return the smoothed speed and turn rate of a trajectory.

    Args:
        to_planar: whether to take the turn rate about z with its sign; else its magnitude about
            any axis.
        smoothing: standard deviation of the Gaussian [s].

    Raises:
        TrajectoryError: the trajectory is too short or too long.
    """
    if not SHORTEST <= trajectory.duration <= LONGEST:
        raise TrajectoryError(
            f"{trajectory.name} lasts {trajectory.duration:.4g} s, too "
            f"{'short' if trajectory.duration < SHORTEST else 'long'} to compare how it moves; "
            f"valid are {SHORTEST:g} to {LONGEST:g} s"
        )
    start, stamps = trajectory.stamps[0], trajectory.stamps
    grid = start + STEP * np.arange(int(trajectory.duration / STEP) + 1)
    speed = np.linalg.norm(_rates(grid, stamps, trajectory.positions, smoothing), axis=1)
    if to_planar:
        turn = _rates(grid, stamps, np.unwrap(trajectory.poses[:, 2])[:, None], smoothing)[:, 0]
    else:
        # The rate of change of a unit quaternion is half the turn rate.
        turn = 2 * np.linalg.norm(_rates(grid, stamps, _continuous(trajectory), smoothing), axis=1)
    return MotionProfile(start, np.stack([speed, turn]), ~in_gap(trajectory, grid))


def longest_step(trajectory: Trajectory) -> float:
    """Return the longest time between two poses [s] that is no gap."""
    return max(GAP, 3 * float(np.median(np.diff(trajectory.stamps))))


def in_gap(
    trajectory: Trajectory, stamps: Array, longest: float | None = None
) -> NDArray[np.bool_]:
    """Return which stamps (n,) are beyond the trajectory's ends or in one of its gaps.

    Args:
        longest: its longest step that is no gap [s], if that is known already.
    """
    known = trajectory.stamps
    longest = longest_step(trajectory) if longest is None else longest
    before = np.clip(np.searchsorted(known, stamps, side="right") - 1, 0, len(known) - 2)
    missing: NDArray[np.bool_] = (
        (stamps < known[0]) | (stamps > known[-1]) | (known[before + 1] - known[before] > longest)
    )
    return missing


def _rates(grid: Array, stamps: Array, values: Array, smoothing: float) -> Array:
    """Return the smoothed rates of change (m, k) of values (n, k)."""
    sampled = np.column_stack([np.interp(grid, stamps, column) for column in values.T])
    rates: Array = gaussian_filter1d(sampled, smoothing / STEP, axis=0, order=1) / STEP
    return rates


def _continuous(trajectory: Trajectory) -> Array:
    """Return quaternions (n, 4), each with the sign that brings it nearer to the previous one."""
    quaternions = trajectory.quaternions
    along = np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1])
    signs = np.cumprod(np.append(1.0, np.where(along < 0, -1.0, 1.0)))
    continuous: Array = quaternions * signs[:, None]
    return continuous


def correlations(truth: MotionProfile, estimate: MotionProfile) -> tuple[Array, Array, Array]:
    """Correlate two profiles at each lag at which they overlap.

    The correlation is of both channels together, each minus its mean over the overlap. Turn rates
    are multiplied by the length that makes them as large as speeds.

    Returns:
        The time to add to the estimate's stamps [s], the correlation in [-1, 1], and the part of
        the shorter profile's known samples that overlaps, in [0, 1], each (m,).
    """
    speed, turn = np.sqrt(np.mean(np.square(truth.channels), axis=1))
    lever = np.array([[1.0], [np.clip(speed / max(turn, 1e-9), *LEVERS)]])
    ours, theirs = _centred(truth, lever), _centred(_clipped(estimate, truth), lever)
    n, m = ours.shape[1], theirs.shape[1]
    lags, size = np.arange(1 - m, n), next_fast_len(n + m, real=True)

    def summed(a: Array, b: Array) -> Array:
        """Return the sums of products (2, k) at all lags."""
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
    """Clip a profile to the target's values: the high speeds of jumps would hide all else."""
    slowest, fastest = target.channels.min(axis=1), target.channels.max(axis=1)
    within = np.clip(profile.channels, slowest[:, None], fastest[:, None])
    return replace(profile, channels=within)


def _centred(profile: MotionProfile, lever: Array) -> Array:
    """Return the channels (2, n) minus their means, and zero where nothing is known."""
    known = profile.known
    if not known.any():
        return np.zeros_like(profile.channels)
    means = profile.channels[:, known].mean(axis=1, keepdims=True)
    centred: Array = np.where(known, profile.channels - means, 0.0) * lever
    return centred
