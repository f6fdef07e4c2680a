"""All that a drive with truth tells of odometry: its steady errors, and how the rest spreads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion.drive_correction import DriveCorrection
from app.lab.model_fits.motion.fit import FIT_HORIZONS, Interval, MotionFit, fit_motion, likeliest
from app.lab.model_fits.motion.robust_correction import HORIZONS, TYPICAL, robust_correction
from app.lab.model_fits.motion.run import MotionRun
from app.lab.model_fits.motion.windows import Comparison, Cut, cut, together, windows
from robot.geometry import Array

ROUNDS = 3
"""After so many the two halves of the fit move each other no more."""

BLOCK = 40.0
"""Errors this far apart [s] are taken as independent for the intervals."""

LEAST_BLOCKS = 5
"""From fewer, nothing is known of how sure the result is."""


@dataclass(frozen=True)
class DriveFit:
    """Odometry's steady errors and the motion model's alphas."""

    correction: DriveCorrection
    intervals: tuple[Interval, Interval, Interval]
    """95 % intervals of distance, turn and curvature."""
    motion: MotionFit
    """What is left, odometry being corrected."""


def fit_drive(
    runs: Sequence[MotionRun],
    *,
    track: float = 0.0,
    horizons: Sequence[float] = HORIZONS,
    fit_horizons: Sequence[float] = FIT_HORIZONS,
) -> DriveFit:
    """Find correction and alphas under which truth is likeliest.

    In turns, on the shortest windows: with the covariance of each window the correction is found by
    least squares, and with the correction the covariances; the first correction is a robust one.
    In the end the alphas are fitted to windows of all lengths, each length counting the same: a
    composite likelihood (Varin, Reid and Firth 2011), as they are parts of each other. The
    correction's intervals are those of clustered errors (the sandwich of Huber 1967), which neither
    windows that overlap nor errors that last make too narrow.

    Args:
        runs: drives at even stamps, all with the same step.
        track: distance between the wheels that odometry believes in [m], if it is known.
        horizons: those of the first correction [s].
        fit_horizons: lengths of the windows of the fit [s], the shortest first; a drive that is
            shorter is a window as a whole.

    Raises:
        FitError: too little was driven or turned, or in too few pieces; says what is needed.
    """
    cuts = cut(runs, fit_horizons[0], keep_short=True)
    blocks, compared = _blocks(cuts), Comparison.of(cuts)
    correction = robust_correction(runs, horizons=horizons, track=track)
    for _ in range(ROUNDS):
        whiten = _whitening(runs, fit_horizons[0], correction)
        problem = _Problem(compared, whiten, track)
        start = np.array([correction.distance, correction.turn, correction.curvature])
        found = least_squares(problem.residuals, start, x_scale=TYPICAL).x
        correction = problem.correction(found)
    deviations = problem.deviations(found, blocks)
    reach = float(student.ppf(0.975, blocks.max())) * deviations
    all_windows = [windows(runs, one, correction, keep_short=True) for one in fit_horizons]
    low, high = (found - reach).tolist(), (found + reach).tolist()
    return DriveFit(
        correction,
        ((low[0], high[0]), (low[1], high[1]), (low[2], high[2])),
        fit_motion(together(all_windows)),
    )


@dataclass(frozen=True, eq=False)
class _Problem:
    """The correction as least squares."""

    compared: Comparison
    whiten: Array
    """(n, 3, 3): what makes errors of a window independent and of size one."""
    track: float

    def correction(self, found: Array) -> DriveCorrection:
        return DriveCorrection(float(found[0]), float(found[1]), float(found[2]), self.track)

    def residuals(self, found: Array) -> Array:
        errors = self.compared.errors(self.correction(found))
        flat: Array = (self.whiten @ errors[..., None]).ravel()
        return flat

    def deviations(self, found: Array, blocks: Array) -> Array:
        """Standard deviations (3,) of what was found, from how much each stretch pulls at it."""
        nudge = 1e-3 * TYPICAL
        columns = [
            (self.residuals(found + d) - self.residuals(found - d)) / (2 * nudge)
            for d in nudge * np.eye(3)
        ]
        J = np.stack(columns, axis=1)
        count = int(blocks.max()) + 1
        by_block = np.zeros((count, 3))
        np.add.at(by_block, np.repeat(blocks, 3), J * self.residuals(found)[:, None])
        bread = np.linalg.inv(J.T @ J)
        spread = bread @ (by_block.T @ by_block) @ bread * count / (count - 1)
        deviations: Array = np.sqrt(np.diag(spread))
        return deviations


def _whitening(runs: Sequence[MotionRun], horizon: float, correction: DriveCorrection) -> Array:
    parts, _, logs = likeliest(windows(runs, horizon, correction, keep_short=True))
    inverse: Array = np.linalg.inv(np.linalg.cholesky(parts.covariances(logs)))
    return inverse


def _blocks(cuts: Sequence[Cut]) -> Array:
    """For each window which stretch it lies in; drives are cut into stretches about as long."""
    numbers, first = [], 0
    for one in cuts:
        run = one.run
        count = max(round(run.duration / BLOCK), 1)
        middle = (run.stamps[one.start] + run.stamps[one.end]) / 2 - run.stamps[0]
        place = (middle / run.duration * count).astype(int)
        numbers.append(first + np.minimum(place, count - 1))
        first += count
    if first < LEAST_BLOCKS:
        raise FitError(
            f"the drives make {first} stretches of {BLOCK:g} s; at least {LEAST_BLOCKS} are "
            f"needed: {LEAST_BLOCKS * BLOCK:g} s, or {LEAST_BLOCKS} drives"
        )
    return np.concatenate(numbers)
