"""Regions that should hold 95 % of the true ends of a motion, and what share they do hold."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from app.model_fits.drive_correction import DriveCorrection
from app.model_fits.motion_fit import MotionFit
from app.model_fits.motion_run import FitError, MotionRun
from app.model_fits.motion_windows import Windows, windows
from robot.geometry import Array

HORIZONS = (1.0, 5.0, 20.0)
"""Times over which ends of motions are predicted [s]."""

SHARE = 0.95

STRIDES = 10
"""Windows begin this many times in a horizon."""


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


def fit_regions(
    runs: Sequence[MotionRun],
    correction: DriveCorrection,
    fit: MotionFit,
    *,
    horizons: Sequence[float] = HORIZONS,
    share: float = SHARE,
) -> tuple[Region, ...]:
    """Regions that hold their share of drives like these.

    The threshold is the split-conformal quantile (Lei et al. 2018): of n windows that do not
    overlap it is the ceil((n + 1) share)-th smallest distance, whatever the distances are
    distributed like. Windows that overlap make the quantile less rough.

    Raises:
        FitError: a horizon has too few windows to tell of such a share; says what it takes.
    """
    return tuple(_region(_cut(runs, horizon, correction), fit, share) for horizon in horizons)


def share_held(
    runs: Sequence[MotionRun], correction: DriveCorrection, fit: MotionFit, region: Region
) -> float:
    """Share of the true ends that lie in a region, over all windows of its length.

    Raises:
        FitError: no drive is as long.
    """
    distances = squared_distances(_cut(runs, region.horizon, correction), fit)
    return float(np.mean(distances <= region.threshold))


def usable_horizons(
    runs: Sequence[MotionRun], *, horizons: Sequence[float] = HORIZONS, share: float = SHARE
) -> tuple[float, ...]:
    """The horizons that drives have enough windows of to fit regions."""
    return tuple(
        horizon
        for horizon in horizons
        if sum(run.duration for run in runs if run.duration >= horizon) / horizon
        >= least_windows(share)
    )


def least_windows(share: float = SHARE) -> int:
    """Fewer independent windows than these do not tell what holds a share: 19 for 95 %."""
    return math.ceil(share / (1 - share) - 1e-9)


def squared_distances(of: Windows, fit: MotionFit) -> Array:
    """Squared Mahalanobis distances (n,) of the true ends of windows."""
    pulls = np.linalg.solve(fit.covariances(of), of.errors[..., None])[..., 0]
    distances: Array = np.sum(of.errors * pulls, axis=1)
    return distances


def _cut(runs: Sequence[MotionRun], horizon: float, correction: DriveCorrection) -> Windows:
    return windows(runs, horizon, correction, stride=horizon / STRIDES)


def _region(of: Windows, fit: MotionFit, share: float) -> Region:
    n = of.independent
    if n < least_windows(share) - 0.5:
        raise FitError(
            f"{n:.0f} windows of {of.horizon:g} s cannot tell what holds {share:.0%} of them; "
            f"it takes {least_windows(share)}: {least_windows(share) * of.horizon:g} s of driving"
        )
    level = min(math.ceil((n + 1) * share) / n, 1.0)
    threshold = float(np.quantile(squared_distances(of, fit), level))
    along, across, heading = np.sqrt(np.einsum("nii->i", fit.covariances(of)) / len(of)).tolist()
    return Region(of.horizon, share, threshold, n, along, across, heading)
