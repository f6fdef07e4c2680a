"""Fit odometry's systematic errors, and the spread of the remaining ones, to drives with truth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student

from app.features.lab.model_fits.likelihood import (
    FitError,
    Interval,
    Loss,
    Peak,
    interval_of,
    likeliest,
)
from app.features.lab.model_fits.motions import DriveCorrection, MotionRun
from app.features.lab.model_fits.windows import Windows, join_windows, windows
from robot.geometry import Array

HORIZONS = (5.0, 10.0, 20.0)
"""Lengths of the windows that the alphas are fitted to [s]; the correction uses the first. In
shorter windows small errors of stamps look like noise. With one length alone, errors that grow
with the distance are hard to separate from constant ones."""

ROUNDS, ENOUGH = 8, 0.01
"""Largest number of rounds; they end when all values move by less than this share of their standard
deviation."""

STRETCH = 32
"""Number of windows in a stretch (40 s): errors farther apart are taken as independent."""

LEAST_WINDOWS = 20
"""From fewer independent windows a variance is not even known to a factor of two."""

LEAST_TURN, LEAST_WAY = 0.05, 0.01
"""Windows must turn by at least this [rad] and move by this [m] on average, to show such errors."""

NOTHING = 1e-13
"""Smallest alpha, and smallest variance of the truth [m², rad²]."""

TYPICAL = 0.01
"""Typical size of the errors of distance, turn and curvature."""


@dataclass(frozen=True)
class MotionFit:
    """Alphas of ``DifferentialMotion`` for steps of one length, and the errors left at rest."""

    alphas: tuple[float, float, float, float]
    intervals: tuple[Interval, ...]
    """95 % intervals of the alphas; they begin at 0 if the data may not need the alpha."""
    floor_xy: float
    """Standard deviation along and across of a pose, at both ends of a motion [m]: the truth has
    errors too, and encoders count in whole steps."""
    floor_theta: float
    """The same for the heading [rad]."""
    independent: float
    """Number of independent windows in the fit."""
    step: float
    """Duration of a step [s]; the alphas hold for this duration."""

    @property
    def factors(self) -> Array:
        """(6,) of the parts of windows: the alphas and the variances of the floors."""
        return np.array([*self.alphas, self.floor_xy**2, self.floor_theta**2])


@dataclass(frozen=True)
class DriveFit:
    """Odometry's systematic errors and the motion model's alphas."""

    correction: DriveCorrection
    intervals: tuple[Interval, ...]
    """95 % intervals of distance, turn and curvature."""
    motion: MotionFit
    """The errors that remain after the correction."""


def fit_drive(runs: Sequence[MotionRun], *, track: float = 0.0) -> DriveFit:
    """Find the correction and the alphas under which the truth is likeliest.

    First the correction is fitted to the shortest windows together with their alphas. That takes
    rounds, as errors are linear in the correction only for small changes. Then the alphas are
    fitted to windows of all lengths. As these overlap, this is a composite likelihood (Varin, Reid
    and Firth 2011).

    Drives have even stamps, all with the same step. A drive that is shorter than a window is one
    window. The track [m] is the one that odometry assumes, if it is known.

    Raises:
        FitError: the robot drives or turns too little; says what is needed.
    """
    values, start = np.array([1.0, 1.0, 0.0]), None
    for _ in range(ROUNDS):
        correction = DriveCorrection(*[*values.tolist(), track])
        cut = windows(runs, HORIZONS[0], correction, keep_short=True)
        peak = _peak(cut, cut.slopes, start)
        start, values = peak.place[:6], values + peak.place[6:]
        deviations = np.sqrt(np.diag(peak.covariance)[6:])
        if (np.abs(peak.place[6:]) < ENOUGH * deviations).all():
            break
    reach = _reach(cut, peak)
    low, high = values - reach, values + reach
    correction = DriveCorrection(*[*values.tolist(), track])
    several = [windows(runs, horizon, correction, keep_short=True) for horizon in HORIZONS]
    intervals = tuple(zip(low.tolist(), high.tolist(), strict=True))
    cut = join_windows(several)
    # The fitted correction makes the errors smaller, as subtracting a sample's mean does.
    growth = math.sqrt(cut.independent / (cut.independent - 1))
    return DriveFit(correction, intervals, fit_motion(replace(cut, errors=growth * cut.errors)))


def _reach(cut: Windows, peak: Peak) -> Array:
    """Return half the 95 % intervals (3,) of the correction.

    They come from the scores of the stretches and the curvature (the sandwich of Huber 1967):
    errors that last long make the scores of stretches larger.
    """
    errors = cut.errors + cut.slopes @ peak.place[6:]
    pulls = np.linalg.solve(cut.covariances(peak.place[:6]), errors[..., None])[..., 0]
    first = np.searchsorted(cut.drive, cut.drive)
    stretch = (np.arange(len(cut)) - first) // STRETCH
    _, number = np.unique(cut.drive * len(cut) + stretch, return_inverse=True)
    sums = np.zeros((int(number.max()) + 1, 3))
    np.add.at(sums, number, cut.weights[:, None] * np.einsum("nic,ni->nc", cut.slopes, pulls))
    covariance, count = peak.covariance[6:, 6:], len(sums)
    spread = covariance @ (sums.T @ sums) @ covariance * count / (count - 1)
    reach: Array = float(student.ppf(0.975, count - 1)) * np.sqrt(np.diag(spread))
    return reach


def fit_motion(cut: Windows) -> MotionFit:
    """Find the alphas under which the errors of windows are likeliest.

    Windows that overlap count as many as would fit side by side. They contain a little more
    information than that, so the intervals are somewhat too wide. This is accepted, as real errors
    never follow the model exactly.

    Raises:
        FitError: there are too few windows, or they turn or move too little; says what is needed.
    """
    peak = _peak(cut, cut.slopes[..., :0])
    variances = np.diag(peak.covariance)
    alpha1, alpha2, alpha3, alpha4 = np.where(peak.free, peak.place, 0.0)[:4].tolist()
    return MotionFit(
        (alpha1, alpha2, alpha3, alpha4),
        tuple(
            interval_of(float(peak.place[k]), float(variances[k]))
            if peak.free[k]
            else (0.0, peak.upper_bound_at_zero(k))
            for k in range(4)
        ),
        math.sqrt(peak.place[4]),
        math.sqrt(peak.place[5]),
        cut.independent,
        cut.step,
    )


def motion_loss(cut: Windows, slopes: Array) -> Loss:
    """Return minus the log-likelihood, by factors (6,) of the windows' parts and a correction (c,).

    The slopes (n, 3, c) are the derivatives of the errors by the correction.
    """
    flat = cut.parts.reshape(len(cut.parts), -1)

    def loss(place: Array) -> tuple[float, Array]:
        factors, correction = np.split(place, [len(flat)])
        errors = cut.errors + slopes @ correction
        inverse = np.linalg.inv(cut.covariances(factors))
        pulls = np.einsum("nij,nj->ni", inverse, errors)
        terms = np.sum(errors * pulls, axis=1) - np.linalg.slogdet(inverse)[1]
        excess = cut.weights[:, None, None] * (inverse - pulls[:, :, None] * pulls[:, None, :])
        by_correction = np.einsum("n,ni,nic->c", cut.weights, pulls, slopes)
        value = float(cut.weights @ (terms + 3 * math.log(2 * math.pi))) / 2
        return value, np.concatenate([flat @ excess.ravel() / 2, by_correction])

    return loss


def _peak(cut: Windows, slopes: Array, start: Array | None = None) -> Peak:
    _check_enough(cut)
    spread = cut.errors.T @ cut.errors / len(cut) + 1e-12 * np.eye(3)
    sizes = np.einsum("ij,cnji->c", np.linalg.inv(spread), cut.parts) / len(cut)
    # Start with parts that explain equally much.
    even = np.maximum(3 / (len(sizes) * np.maximum(sizes, 1e-12)), 10 * NOTHING)
    count = slopes.shape[-1]
    none = np.zeros(count)
    return likeliest(
        motion_loss(cut, slopes),
        np.concatenate([even if start is None else np.maximum(start, 0.01 * even), none]),
        np.concatenate([even, none + TYPICAL]),
        np.concatenate([np.full(6, NOTHING), none - math.inf]),
        np.full(6 + count, math.inf),
    )


def _check_enough(cut: Windows) -> None:
    turn = float(np.mean(np.abs(cut.moved[:, 2])))
    way = float(np.mean(np.hypot(cut.moved[:, 0], cut.moved[:, 1])))
    if cut.independent < LEAST_WINDOWS:
        raise FitError(
            f"{cut.independent:.0f} windows of {cut.horizon:g} s; at least {LEAST_WINDOWS} are "
            f"needed, which is {LEAST_WINDOWS * cut.horizon:g} s of driving"
        )
    if turn < LEAST_TURN:
        raise FitError(
            f"windows of {cut.horizon:g} s turn by {turn:.3f} rad on the mean; alpha1 and alpha4 "
            f"cannot be told below {LEAST_TURN:g} rad: drive turns too"
        )
    if way < LEAST_WAY:
        raise FitError(
            f"windows of {cut.horizon:g} s go {way:.3f} m on the mean; alpha2 and alpha3 cannot "
            f"be told below {LEAST_WAY:g} m: drive straight on too"
        )
