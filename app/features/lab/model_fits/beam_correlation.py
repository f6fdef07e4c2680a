"""Correlation of the errors of rays, and the number of independent rays that they are worth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.features.lab.model_fits.likelihood import FitError, Interval
from app.features.lab.model_fits.range_pairs import TO_SD, RangePairs
from robot.geometry import Array
from robot.scan import evenly

FEWEST_SCANS = 10
RESAMPLES = 500
LEAST_SD = 1e-9
"""Errors with a smaller standard deviation count as equal [m]."""
WILD = 10.0
"""Errors larger than this many robust standard deviations are outliers."""
LONGEST = 100
"""Largest lag at which scans are compared."""


@dataclass(frozen=True, eq=False)
class BeamCorrelation:
    """Correlation of range errors, and the ``likelihood_weight`` that follows from it.

    Intervals are of 95 %, by the bootstrap over scans. It draws blocks of successive scans that are
    twice as long as the correlation time of the errors.
    """

    by_ray: Array
    """(k,) between rays of a scan that are 0, 1, ... apart; nan if there are no such pairs."""
    by_scan: Array
    """(s,) of a ray between scans that are 0, 1, ... apart."""
    rays_used: int
    """Rays of a scan that a filter uses: n."""
    rays_worth: float
    """Independent rays that those are worth: n_eff."""
    rays_worth_interval: Interval
    likelihood_weight: float
    """If the errors of scans are independent: n_eff / n, at most 1."""
    likelihood_weight_interval: Interval
    scans_a_new_one: float
    """Successive scans that are worth one independent scan: 1 + 2 times the sum of ``by_scan``."""
    scans_a_new_one_interval: Interval
    likelihood_weight_of_successive_scans: float
    """If a filter uses every scan: ``likelihood_weight`` / ``scans_a_new_one``.

    The correlation of two rays some rays and some scans apart is taken to be the product of both
    correlations.
    """
    likelihood_weight_of_successive_scans_interval: Interval


def correlate_beams(
    pairs: RangePairs, max_beams: int, *, resamples: int = RESAMPLES, seed: int = 0
) -> BeamCorrelation:
    """Correlate the errors of good returns; other returns are left out as if not measured.

    The mean error over all scans is subtracted, not that of each scan: an error of a whole scan is
    an error that its rays have in common.

    All scans have the same rays, of which a filter uses ``max_beams``, evenly spread.

    Raises:
        FitError: there are too few scans, or no scan has two good returns.
    """
    table = _table(pairs)
    scans, rays = table.shape
    ray_sums, scan_sums = _lag_sums(table, rays, 1), _lag_sums(table, min(scans // 2, LONGEST), 0)
    used, chance = evenly(rays, max_beams), np.random.default_rng(seed)
    by_ray, by_scan = (_correlations(sums, np.ones(scans)) for sums in (ray_sums, scan_sums))
    worth, duration = independent_rays(by_ray, used), correlation_time(by_scan)
    block = min(math.ceil(2 * duration), scans // 2)
    draws = [_blocks(chance, scans, block) for _ in range(resamples)]
    worths = np.array([independent_rays(_correlations(ray_sums, draw), used) for draw in draws])
    durations = np.array([correlation_time(_correlations(scan_sums, draw)) for draw in draws])
    shares = np.minimum(worths / len(used), 1.0)
    share = min(worth / len(used), 1.0)
    return BeamCorrelation(
        by_ray,
        by_scan,
        len(used),
        worth,
        _interval(worths),
        share,
        _interval(shares),
        duration,
        _interval(durations),
        min(worth / (len(used) * max(duration, 1.0)), 1.0),
        _interval(np.minimum(worths / (len(used) * np.maximum(durations, 1.0)), 1.0)),
    )


def independent_rays(by_ray: Array, used: NDArray[np.intp]) -> float:
    """Return how many independent rays some rays are worth: n^2 / (sum of all correlations).

    For n neighbours that is n / (1 + 2 sum of (1 - k / n) rho_k), k = 1 to n - 1. The arguments are
    the correlation (k,) by lag of rays, from lag 0 on, and the numbers (n,) of the rays.
    """
    positive = initial_positive(by_ray)
    distances = np.abs(used[:, None] - used[None, :]).ravel()
    correlations = np.zeros(max(int(distances.max()) + 1, len(positive)))
    correlations[: len(positive)] = positive
    return len(used) ** 2 / float(correlations[distances].sum())


def correlation_time(correlations: Array) -> float:
    """Return 1 + 2 times the sum of the correlations at lags from 1 on; the first (k,) is lag 0."""
    return 2 * float(initial_positive(correlations).sum()) - 1


def initial_positive(correlations: Array) -> Array:
    """Return the correlations up to the first pair of neighbours whose sum is not positive.

    Beyond it they are chance, and their sum has no limit (initial positive sequence: Geyer,
    Practical Markov Chain Monte Carlo, 1992). nan, of a lag without pairs, ends them too.
    """
    pair_sums = correlations[: len(correlations) // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(~(pair_sums > 0))
    return correlations[: 2 * (int(ends[0]) if len(ends) else len(pair_sums))]


def _table(pairs: RangePairs) -> Array:
    """Return the errors of good returns (scans, rays) minus their mean [m]; nan elsewhere.

    One large error would hide the correlation of thousands of others, and a sensor model takes it
    for a false return. So errors above ``WILD`` robust standard deviations are left out.
    """
    errors, good = pairs.residuals, pairs.right
    # If the median is 0, no error is an outlier.
    gate = WILD * TO_SD * float(np.median(np.abs(errors[good]))) if good.any() else 0.0
    good &= np.abs(errors) <= (gate or math.inf)
    shape = (int(pairs.scan.max(initial=-1)) + 1, int(pairs.ray.max(initial=-1)) + 1)
    table = np.full(shape, np.nan)
    table[pairs.scan[good], pairs.ray[good]] = errors[good]
    most = int(np.isfinite(table).sum(axis=1).max(initial=0))
    if len(table) < FEWEST_SCANS or most < 2:
        raise FitError(
            f"{len(table)} scans with at most {most} returns from edges in one; needed are "
            f"{FEWEST_SCANS} scans or more, and two returns in one"
        )
    if not np.nanstd(table) > LEAST_SD:
        raise FitError("all ranges are off by the same; needed are errors that differ")
    centred: Array = table - np.nanmean(table)
    return centred


def _lag_sums(table: Array, lags: int, axis: int) -> Array:
    """Return (2, s, k): for each scan and lag the sum of products of errors, and their number.

    Errors (s, r) are compared between scans along axis 0, between rays along axis 1; nan means no
    error.
    """
    values = np.stack([np.nan_to_num(table), np.isfinite(table)]).swapaxes(1, 1 + axis)
    length = values.shape[1]
    sums = np.zeros((2, len(table), lags))
    for lag in range(lags):
        products = values[:, : length - lag] * values[:, lag:]
        by_scan = products.sum(axis=2 - axis)
        sums[:, : by_scan.shape[1], lag] = by_scan
    return sums


def _correlations(sums: Array, times: Array) -> Array:
    """Return the correlations by lag (k,); ``times`` (s,) weights the scans; nan without pairs."""
    products, counts = times @ sums
    with np.errstate(invalid="ignore"):
        covariances = products / counts
    correlations: Array = covariances / covariances[0]
    return correlations


def _blocks(chance: np.random.Generator, scans: int, block: int) -> Array:
    """Draw blocks of successive scans, around a circle; return how often each occurs (s,)."""
    starts = chance.integers(0, scans, math.ceil(scans / block))
    scans_used = (starts[:, None] + np.arange(block)).ravel()[:scans] % scans
    return np.bincount(scans_used, minlength=scans).astype(np.float64)


def _interval(values: Array) -> Interval:
    low, high = np.percentile(values, [2.5, 97.5]).tolist()
    return low, high
