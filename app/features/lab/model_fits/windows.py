"""Cut drives into windows: the errors of odometry at their ends, and their possible causes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.motions import (
    DriveCorrection,
    MotionRun,
    chained,
    relative,
    seen_from,
    twists_of,
)
from robot.geometry import Array, wrap_angle
from robot.localization.models.odometry_motion import STANDING_M

AS_IT_IS = DriveCorrection()


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of drives; they may overlap."""

    horizon: float
    """Length of each window, or of the shortest [s]; a shorter drive is one window."""
    step: float
    """Duration of a step of the motion model [s]."""
    independent: float
    """Number of windows that fit without overlap."""
    moved: Array
    """(n, 3) [m, m, rad]: the window's end by odometry, seen from its start."""
    errors: Array
    """(n, 3) [m, m, rad]: the true end seen from the end by odometry, as a twist.

    Turning errors bend the cloud of ends like a banana; as twists, the logarithm of SE(2), the
    cloud is normal (Long, Wolfe, Mashner and Chirikjian 2012).
    """
    parts: Array
    """(6, n, 3, 3): covariance of the errors if each alpha is one; then if the truth at both ends
    has an error of one along and across [m], and in heading [rad]."""
    slopes: Array
    """(n, 3, 3): derivatives of the errors by distance, turn and curvature of the correction."""
    weights: Array
    """(n,): weight of each window, at most one; their sum is at most the independent number."""
    drive: Array
    """(n,): number of the drive that the window is cut from."""

    def __len__(self) -> int:
        return len(self.errors)

    def covariances(self, factors: Array) -> Array:
        """Return the covariances (n, 3, 3) of the errors.

        The factors (6,) are the alphas and the variances of the truth.
        """
        whole: Array = (factors @ self.parts.reshape(len(factors), -1)).reshape(-1, 3, 3)
        return whole


def join_windows(several: Sequence[Windows]) -> Windows:
    """Join windows of several lengths to one set, in which all lengths have equal weight.

    The total weight is the mean of the total weights of the lengths.
    """
    each = np.mean([item.weights.sum() for item in several]) / len(several)
    return Windows(
        several[0].horizon,
        several[0].step,
        several[0].independent,
        np.concatenate([item.moved for item in several]),
        np.concatenate([item.errors for item in several]),
        np.concatenate([item.parts for item in several], axis=1),
        np.concatenate([item.slopes for item in several]),
        np.concatenate([item.weights * (each / item.weights.sum()) for item in several]),
        np.concatenate([item.drive for item in several]),
    )


def windows(
    runs: Iterable[MotionRun],
    horizon: float,
    correction: DriveCorrection = AS_IT_IS,
    *,
    stride: float | None = None,
    keep_short: bool = False,
) -> Windows:
    """Cut drives, at even stamps with the same step, into windows as long as a horizon [s].

    The windows begin a stride apart [s], by default a quarter of the horizon. With ``keep_short`` a
    shorter drive is kept as one window.

    Raises:
        FitError: no drive is as long as the horizon.
    """
    drives = list(runs)
    if not drives:
        raise FitError("there is no drive; one or more are needed")
    step = float(np.median(np.diff(drives[0].stamps)))
    length = max(round(horizon / step), 1)
    apart = max(round((horizon / 4 if stride is None else stride) / step), 1)
    long = [run for run in drives if keep_short or len(run.stamps) > length]
    if not long:
        longest = max(run.duration for run in drives)
        raise FitError(f"windows of {horizon:g} s are asked; the longest drive has {longest:.1f} s")
    cuts = [_cut(run, length, apart, correction) for run in long]
    moved, errors, spreads, slopes = (np.concatenate(each) for each in zip(*cuts, strict=True))
    parts = np.concatenate([spreads, _floors(moved)], axis=1).swapaxes(0, 1)
    independent = sum(max((len(run.stamps) - 1) / length, 1.0) for run in long)
    return Windows(
        horizon,
        step,
        independent,
        moved,
        errors,
        np.ascontiguousarray(parts),
        slopes,
        np.full(len(errors), min(independent / len(errors), 1.0)),
        np.repeat(np.arange(len(long)), [len(item[0]) for item in cuts]),
    )


def _cut(
    run: MotionRun, length: int, apart: int, correction: DriveCorrection
) -> tuple[Array, Array, Array, Array]:
    """Cut a drive into windows of some steps, or take the whole drive if it is shorter.

    Returns:
        Motions and errors (n, 3), covariances by alpha (n, 4, 3, 3), slopes by correction
        (n, 3, 3).
    """
    steps = correction.corrected(run.steps)
    length = min(length, len(steps))
    start = np.arange(0, len(steps) - length + 1, apart)
    end = start + length
    path = chained(steps)
    moved = relative(path[start], path[end])
    errors = twists_of(relative(moved, relative(run.truth[start], run.truth[end])))
    to_end = seen_from(path[end])
    spreads = to_end[:, None] @ summed(by_alpha(path, steps), start, end)
    slopes = to_end @ summed(_by_correction(path, run.steps, correction.track), start, end)
    return moved, errors, spreads @ to_end[:, None].swapaxes(-1, -2), -slopes


def summed(of_steps: Array, start: NDArray[np.intp], end: NDArray[np.intp]) -> Array:
    """Sum values of steps (n, ...) from start (k,) up to end (k,) indices; returns (k, ...)."""
    sums = np.zeros((len(of_steps) + 1, *of_steps.shape[1:]))
    np.cumsum(of_steps, axis=0, out=sums[1:])
    windows_have: Array = sums[end] - sums[start]
    return windows_have


def _by_correction(poses: Array, steps: Array, track: float) -> Array:
    """Return how distance, turn and curvature move the ends: twists (n, 3, 3) from the start."""
    twists = twists_of(steps)
    moves = np.zeros((len(steps), 3, 3))
    moves[:, :2, 0] = twists[:, :2]
    moves[:, 2, 1] = twists[:, 2]
    moves[:, 0, 2], moves[:, 2, 2] = track**2 / 4 * twists[:, 2], twists[:, 0]
    return np.asarray(np.linalg.solve(seen_from(poses[1:]), moves), dtype=np.float64)


def by_alpha(poses: Array, steps: Array) -> Array:
    """Return the covariances (n, 4, 3, 3) of steps by alpha, as twists seen from the path's start.

    A step's covariance is linear in alpha1 to alpha4 (Probabilistic Robotics, Table 5.6, with
    alphas as variances). As twists seen from one pose, small errors of steps add up, and so do
    their covariances. The covariance of a window is the difference of two sums.
    """
    distance = np.hypot(steps[:, 0], steps[:, 1])
    turn = np.where(distance <= STANDING_M, 0.0, np.arctan2(steps[:, 1], steps[:, 0]))
    toward = poses[:-1, 2] + turn
    first_turn, last_turn = _outer(_turning_at(poses[:-1])), _outer(_turning_at(poses[1:]))
    going = _outer(np.stack([np.cos(toward), np.sin(toward), np.zeros_like(toward)], axis=-1))
    square1, square2 = _square(turn), _square(wrap_angle(steps[:, 2] - turn))
    way = np.square(distance)[:, None, None]
    return np.stack(
        [
            square1 * first_turn + square2 * last_turn,
            way * (first_turn + last_turn),
            way * going,
            (square1 + square2) * going,
        ],
        axis=1,
    )


def _square(turn: Array) -> Array:
    """Return the squares (n, 1, 1) of the smaller turns, forward or in reverse."""
    smaller = np.minimum(np.abs(turn), np.abs(wrap_angle(turn + np.pi)))
    return np.square(smaller)[:, None, None]


def _turning_at(poses: Array) -> Array:
    """Return the twists (n, 3) of a turn by one radian about the positions of the poses."""
    return np.stack([poses[:, 1], -poses[:, 0], np.ones(len(poses))], axis=-1)


def _outer(vectors: Array) -> Array:
    return vectors[:, :, None] * vectors[:, None, :]


def _floors(moved: Array) -> Array:
    """Return the covariances (n, 2, 3, 3) of motions (n, 3) with ends known to 1 m, and to 1 rad.

    Seen from the end, an error in the heading of the start is also an error in position.
    """
    at_end = np.array([np.diag([1.0, 1.0, 0.0]), np.diag([0.0, 0.0, 1.0])])
    to_end = seen_from(moved)[:, None]
    whole: Array = at_end + to_end @ at_end @ to_end.swapaxes(-1, -2)
    return whole
