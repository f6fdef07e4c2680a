"""Regions that should hold 95 % of the true ends of a motion, and what they do hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta, chi2

from app.lab.model_fits.likelihood import FitError, Interval
from app.lab.model_fits.motion_fit import MotionFit
from app.lab.model_fits.runs import MotionRun
from app.lab.model_fits.twists import DriveCorrection
from app.lab.model_fits.windows import Windows, windows
from robot.geometry import Array

HORIZONS = (1.0, 5.0, 20.0)
"""Times over which ends of motions are predicted [s]."""

SHARE = 0.95
"""What regions should hold, and how sure intervals are."""

STRIDES = 10
"""Windows begin this many times in a horizon."""

LEAST_WINDOWS = 10
"""The largest of fewer distances holds less than 90 % of others."""

Judgement = Literal["honest", "too sure", "too cautious"]


@dataclass(frozen=True)
class Region:
    """Where motions of one length should end: an ellipsoid about odometry's end, as a twist."""

    horizon: float
    """[s]"""
    share: float
    """What share of the ends it should hold."""
    threshold: float
    """Largest squared Mahalanobis distance of an end inside, by the fitted covariance."""
    independent: float
    """How many windows side by side it was taken from."""
    sd_along: float
    """Standard deviation of the ends along the way [m], root mean square over the windows."""
    sd_across: float
    """The same across [m]."""
    sd_heading: float
    """The same of the heading [rad]."""

    @property
    def stretch(self) -> float:
        """How much wider it is than normal errors of the fitted covariance would need."""
        return math.sqrt(self.threshold / float(chi2.ppf(self.share, 3)))


@dataclass(frozen=True, slots=True)
class Held:
    """A region, and what it held of drives that it was not fitted to."""

    region: Region
    share: float
    """Of all windows of its length."""
    interval: Interval
    """Of 95 %: which shares of endless drives like these this one may come from."""
    independent: float
    """How many independent windows the share is worth."""

    @property
    def judgement(self) -> Judgement:
        """Whether the share that it should hold is in the interval; else on which side it errs.

        Honest therefore means not refuted: of few windows the interval is wide. From fewer than
        72 it reaches below 95 % even if all are held.
        """
        low, high = self.interval
        if high < self.region.share:
            return "too sure"
        return "too cautious" if low > self.region.share else "honest"


def usable_horizons(runs: Sequence[MotionRun]) -> tuple[float, ...]:
    """The horizons that drives have enough windows of to fit regions."""
    return tuple(
        horizon
        for horizon in HORIZONS
        if sum(run.duration for run in runs if run.duration >= horizon) >= LEAST_WINDOWS * horizon
    )


def fit_region(
    runs: Sequence[MotionRun], correction: DriveCorrection, fit: MotionFit, horizon: float
) -> Region:
    """The region that holds its share of drives like these.

    The threshold is the split-conformal quantile (Lei et al. 2018): of n windows that do not
    overlap the ceil((n + 1) share)-th smallest distance, whatever the distances are distributed
    like; the largest where there are fewer than 19 for 95 %. Side by side windows can be laid from
    ten places on; their thresholds are averaged.

    Raises:
        FitError: there are too few windows to tell of such a share; says what it takes.
    """
    cut = _windows(runs, horizon, correction)
    if cut.independent < LEAST_WINDOWS:
        raise FitError(
            f"{cut.independent:.1f} windows of {horizon:g} s cannot tell what holds {SHARE:.0%} of "
            f"them; it takes {LEAST_WINDOWS}: {LEAST_WINDOWS * horizon:g} s of driving"
        )
    distances = np.split(squared_distances(cut, fit), np.flatnonzero(np.diff(cut.drive)) + 1)
    # Drives that are only just as long as the horizon fill the first places alone.
    rows = (
        np.concatenate([item[place::STRIDES] for item in distances]) for place in range(STRIDES)
    )
    threshold = float(np.mean([_conformal(item) for item in rows if len(item)]))
    along, across, heading = np.sqrt(
        np.einsum("nii->i", cut.covariances(fit.factors)) / len(cut)
    ).tolist()
    return Region(horizon, SHARE, threshold, cut.independent, along, across, heading)


def held_by(
    runs: Sequence[MotionRun], correction: DriveCorrection, fit: MotionFit, region: Region
) -> Held:
    """What a region holds of the true ends of drives.

    The windows overlap, and an error that lasts longer than a window shows in several side by
    side, so they are worth far fewer independent ones: n / (1 + 2 sum of rho_k), with rho_k the
    correlation of being held k windows apart, summed up to the first that is not positive; and no
    more than lie side by side. The interval is Clopper and Pearson's (1934) for so many.

    Raises:
        FitError: no drive is as long.
    """
    cut = _windows(runs, region.horizon, correction)
    holds = squared_distances(cut, fit) <= region.threshold
    drives = np.split(holds, np.flatnonzero(np.diff(cut.drive)) + 1)
    independent = min(cut.independent, len(holds) / repetition(drives))
    share = float(holds.mean())
    return Held(region, share, share_interval(share, independent), independent)


def squared_distances(cut: Windows, fit: MotionFit) -> Array:
    """Squared Mahalanobis distances (n,) of the true ends of windows."""
    pulls = np.linalg.solve(cut.covariances(fit.factors), cut.errors[..., None])[..., 0]
    distances: Array = np.sum(cut.errors * pulls, axis=1)
    return distances


def share_interval(share: float, count: float) -> Interval:
    """Clopper and Pearson's interval of a share of ``count`` draws, which need not be whole."""
    held, tail = share * count, (1 - SHARE) / 2
    low = float(beta.ppf(tail, held, count - held + 1)) if held > 0 else 0.0
    high = float(beta.ppf(1 - tail, held + 1, count - held)) if held < count else 1.0
    return low, high


def repetition(drives: Sequence[NDArray[np.bool_]]) -> float:
    """How many windows, 1 or more, say no more than an independent one."""
    mean = np.concatenate(drives).mean()
    deviations = [drive - mean for drive in drives]
    variance = sum(float(item @ item) for item in deviations)
    total = 1.0
    for lag in range(1, max(map(len, deviations))):
        products = sum(float(item[lag:] @ item[:-lag]) for item in deviations if len(item) > lag)
        if products <= 0:
            break
        total += 2 * products / variance
    return total


def _windows(runs: Sequence[MotionRun], horizon: float, correction: DriveCorrection) -> Windows:
    return windows(runs, horizon, correction, stride=horizon / STRIDES)


def _conformal(distances: Array) -> float:
    """The smallest distance that holds the share of others, from distances (n,) like them."""
    n = len(distances)
    return float(np.sort(distances)[min(math.ceil((n + 1) * SHARE), n) - 1])
