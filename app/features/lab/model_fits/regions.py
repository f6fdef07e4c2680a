"""Regions that should hold 95 % of the true ends of a motion, and tests of what they hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta, chi2

from app.features.lab.model_fits.likelihood import FitError, Interval
from app.features.lab.model_fits.motion_fit import MotionFit
from app.features.lab.model_fits.motions import DriveCorrection, MotionRun
from app.features.lab.model_fits.windows import Windows, windows
from robot.geometry import Array

HORIZONS = (1.0, 5.0, 20.0)
"""Times over which ends of motions are predicted [s]."""

SHARE = 0.95
"""Share that regions should hold, and level of the intervals."""

STRIDES = 10
"""Number of windows that begin within one horizon."""

LEAST_WINDOWS = 10
"""With fewer distances, even the largest holds less than 90 % of others."""

Judgement = Literal["honest", "too sure", "too cautious"]


@dataclass(frozen=True)
class Region:
    """Where motions of one duration should end: an ellipsoid of twists about odometry's end."""

    horizon: float
    """[s]"""
    share: float
    """The share of the ends that the region should hold."""
    threshold: float
    """Largest squared Mahalanobis distance of an end inside, by the fitted covariance."""
    independent: float
    """Number of windows side by side that the region was fitted to."""
    sd_along: float
    """Standard deviation of the ends along the path [m], root mean square over the windows."""
    sd_across: float
    """The same across the path [m]."""
    sd_heading: float
    """The same for the heading [rad]."""

    @property
    def stretch(self) -> float:
        """How much wider it is than for normal errors with the fitted covariance."""
        return math.sqrt(self.threshold / float(chi2.ppf(self.share, 3)))


@dataclass(frozen=True, slots=True)
class Held:
    """A region, and the share that it held of drives that it was not fitted to."""

    region: Region
    share: float
    """The share of all windows of its length that the region holds."""
    interval: Interval
    """95 % interval of the share in endless drives like these."""
    independent: float
    """Number of independent windows that the share is worth."""

    @property
    def judgement(self) -> Judgement:
        """Whether the interval contains the share that the region should hold; else on which side.

        "honest" only means not refuted: with few windows the interval is wide. With fewer than 72
        windows it reaches below 95 % even if all are held.
        """
        low, high = self.interval
        if high < self.region.share:
            return "too sure"
        return "too cautious" if low > self.region.share else "honest"


def usable_horizons(runs: Sequence[MotionRun]) -> tuple[float, ...]:
    """Return the horizons for which drives have enough windows to fit regions."""
    return tuple(
        horizon
        for horizon in HORIZONS
        if sum(run.duration for run in runs if run.duration >= horizon) >= LEAST_WINDOWS * horizon
    )


def fit_region(
    runs: Sequence[MotionRun], correction: DriveCorrection, fit: MotionFit, horizon: float
) -> Region:
    """Fit the region that holds its share of drives like these.

    The threshold is the split-conformal quantile (Lei et al. 2018). Of n windows that do not
    overlap, it is the ceil((n + 1) share)-th smallest distance, whatever the distribution of the
    distances. For 95 % and fewer than 19 windows it is the largest distance. Windows side by side
    can begin at ten different offsets; the thresholds of these are averaged.

    Raises:
        FitError: there are too few windows for such a share; says how many are needed.
    """
    cut = _windows(runs, horizon, correction)
    if cut.independent < LEAST_WINDOWS:
        raise FitError(
            f"{cut.independent:.1f} windows of {horizon:g} s cannot tell what holds {SHARE:.0%} of "
            f"them; it takes {LEAST_WINDOWS}: {LEAST_WINDOWS * horizon:g} s of driving"
        )
    distances = np.split(squared_distances(cut, fit), np.flatnonzero(np.diff(cut.drive)) + 1)
    # A drive that is hardly longer than the horizon has windows at the first offsets only.
    rows = (
        np.concatenate([item[index::STRIDES] for item in distances]) for index in range(STRIDES)
    )
    threshold = float(np.mean([_conformal(item) for item in rows if len(item)]))
    along, across, heading = np.sqrt(
        np.einsum("nii->i", cut.covariances(fit.factors)) / len(cut)
    ).tolist()
    return Region(horizon, SHARE, threshold, cut.independent, along, across, heading)


def held_by(
    runs: Sequence[MotionRun], correction: DriveCorrection, fit: MotionFit, region: Region
) -> Held:
    """Return the share of the true ends of drives that a region holds.

    The windows overlap, and an error that lasts longer than a window shows in several windows. So n
    windows are worth far fewer independent ones: n / (1 + 2 sum of rho_k). Here rho_k is the
    correlation of being held at k windows apart, and the sum ends before the first that is not
    positive. There are also no more independent windows than lie side by side. The interval is that
    of Clopper and Pearson (1934) for this number.

    Raises:
        FitError: no drive is as long as the horizon.
    """
    cut = _windows(runs, region.horizon, correction)
    holds = squared_distances(cut, fit) <= region.threshold
    drives = np.split(holds, np.flatnonzero(np.diff(cut.drive)) + 1)
    independent = min(cut.independent, len(holds) / repetition(drives))
    share = float(holds.mean())
    return Held(region, share, share_interval(share, independent), independent)


def squared_distances(cut: Windows, fit: MotionFit) -> Array:
    """Return the squared Mahalanobis distances (n,) of the true ends of windows."""
    pulls = np.linalg.solve(cut.covariances(fit.factors), cut.errors[..., None])[..., 0]
    distances: Array = np.sum(cut.errors * pulls, axis=1)
    return distances


def share_interval(share: float, count: float) -> Interval:
    """Return Clopper and Pearson's interval of a share of ``count`` draws (any real number)."""
    held, tail = share * count, (1 - SHARE) / 2
    low = float(beta.ppf(tail, held, count - held + 1)) if held > 0 else 0.0
    high = float(beta.ppf(1 - tail, held + 1, count - held)) if held < count else 1.0
    return low, high


def repetition(drives: Sequence[NDArray[np.bool_]]) -> float:
    """Return how many windows are worth one independent window, 1 or more."""
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
    """Return the smallest distance that holds the share of others, from like distances (n,)."""
    n = len(distances)
    return float(np.sort(distances)[min(math.ceil((n + 1) * SHARE), n) - 1])
