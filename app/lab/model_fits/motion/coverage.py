"""Regions that should hold 95 % of the true ends of a motion."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.motion.drive_correction import DriveCorrection
from app.lab.model_fits.motion.fit import MotionFit
from app.lab.model_fits.motion.run import MotionRun
from app.lab.model_fits.motion.windows import Cut, Windows, cut, windows
from robot.geometry import Array

HORIZONS = (1.0, 5.0, 20.0)
"""Times over which ends of motions are predicted [s]."""

SHARE = 0.95

STRIDES = 10
"""Windows begin this many times in a horizon."""

LEAST_WINDOWS = 10
"""The largest of fewer distances holds less than 90 % of others."""


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
    overlap the ceil((n + 1) share)-th smallest distance, whatever the distances are distributed
    like; the largest where there are fewer than 19 for 95 %. Side by side windows can be laid from
    ten places on; their thresholds are averaged.

    Raises:
        FitError: a horizon has too few windows to tell of such a share; says what it takes.
    """
    return tuple(_region(runs, horizon, correction, fit, share) for horizon in horizons)


def usable_horizons(
    runs: Sequence[MotionRun], horizons: Sequence[float] = HORIZONS
) -> tuple[float, ...]:
    """The horizons that drives have enough windows of to fit regions."""
    return tuple(
        horizon
        for horizon in horizons
        if sum(run.duration for run in runs if run.duration >= horizon) >= LEAST_WINDOWS * horizon
    )


def squared_distances(of: Windows, fit: MotionFit) -> Array:
    """Squared Mahalanobis distances (n,) of the true ends of windows."""
    pulls = np.linalg.solve(fit.covariances(of), of.errors[..., None])[..., 0]
    distances: Array = np.sum(of.errors * pulls, axis=1)
    return distances


def windows_for(runs: Sequence[MotionRun], horizon: float, correction: DriveCorrection) -> Windows:
    """The windows that a region is fitted to and tried on.

    Raises:
        FitError: no drive is as long.
    """
    return windows(runs, horizon, correction, stride=horizon / STRIDES)


def cut_for(runs: Sequence[MotionRun], horizon: float) -> list[Cut]:
    """Where they start and end, drive by drive."""
    return cut(runs, horizon, stride=horizon / STRIDES)


def _region(
    runs: Sequence[MotionRun],
    horizon: float,
    correction: DriveCorrection,
    fit: MotionFit,
    share: float,
) -> Region:
    of = windows_for(runs, horizon, correction)
    if of.independent < LEAST_WINDOWS:
        raise FitError(
            f"{of.independent:.1f} windows of {horizon:g} s cannot tell what holds {share:.0%} of "
            f"them; it takes {LEAST_WINDOWS}: {LEAST_WINDOWS * horizon:g} s of driving"
        )
    distances, phases = squared_distances(of, fit), _phases(runs, horizon)
    # Drives that are only just as long as the horizon fill the first places alone.
    filled = np.unique(phases)
    thresholds = [_conformal(distances[phases == phase], share) for phase in filled]
    along, across, heading = np.sqrt(np.einsum("nii->i", fit.covariances(of)) / len(of)).tolist()
    threshold = float(np.mean(thresholds))
    return Region(horizon, share, threshold, of.independent, along, across, heading)


def _phases(runs: Sequence[MotionRun], horizon: float) -> Array:
    """For each window from which place on in the horizon it is laid side by side."""
    cuts = cut_for(runs, horizon)
    return np.concatenate([np.arange(len(one.start)) % STRIDES for one in cuts])


def _conformal(distances: Array, share: float) -> float:
    """The smallest distance that holds a share of others, from distances (n,) like them."""
    n = len(distances)
    return float(np.sort(distances)[min(math.ceil((n + 1) * share), n) - 1])
