"""How far the rays of a scan err together, and how many independent ones they are worth."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.lab.model_fits.likelihood import FitError, Interval
from app.lab.model_fits.range_pairs import TO_SD, RangePairs
from robot.geometry import Array
from robot.scan import evenly

FEWEST_SCANS = 10
RESAMPLES = 500
LEAST_SD = 1e-9
"""Errors that differ by less are the same [m]."""
WILD = 10.0
"""An error by so many robust standard deviations is not of the kind that the others are."""
LONGEST = 100
"""Scans farther apart than so many others are not compared."""


@dataclass(frozen=True)
class BeamCorrelation:
    """Correlation of range errors, and what it means for ``likelihood_weight``.

    Intervals are of 95 %, by the bootstrap over scans, drawn in blocks of successive ones that are
    twice as long as errors last.
    """

    by_ray: Array
    """(k,) between rays of a scan that are 0, 1, ... apart; nan where there are no such two."""
    by_scan: Array
    """(s,) of a ray between scans that are 0, 1, ... apart."""
    rays_used: int
    """Rays of a scan that a filter uses: n."""
    rays_worth: float
    """Independent rays that those are worth: n_eff."""
    rays_worth_interval: Interval
    likelihood_weight: float
    """If scans err independently: n_eff / n, 1 at most."""
    likelihood_weight_interval: Interval
    scans_a_new_one: float
    """Successive scans that are worth one independent scan: 1 + 2 times the sum of ``by_scan``."""
    scans_a_new_one_interval: Interval
    likelihood_weight_of_successive_scans: float
    """If a filter counts every scan: ``likelihood_weight`` over ``scans_a_new_one``.

    Rays that are so many rays and so many scans apart are taken to be as correlated as the product
    of both correlations.
    """
    likelihood_weight_of_successive_scans_interval: Interval


def correlate_beams(
    pairs: RangePairs, max_beams: int, *, resamples: int = RESAMPLES, seed: int = 0
) -> BeamCorrelation:
    """Correlation of the errors of good returns; the rest is left out as if not measured.

    The mean error over everything is taken off, not that of each scan: what a whole scan is off by
    is what its rays are off by together.

    All scans have the same rays, of which a filter uses ``max_beams``, evenly spread.

    Raises:
        FitError: too few scans, or no two rays that returned what they should.
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
    """How many independent rays some rays of a scan are worth: n^2 / (sum of all correlations).

    For n neighbours that is n / (1 + 2 sum of (1 - k / n) rho_k), k = 1 to n - 1.
    By the correlation (k,) by lag of rays, from lag 0 on, and the numbers (n,) of the rays.
    """
    positive = initial_positive(by_ray)
    distances = np.abs(used[:, None] - used[None, :]).ravel()
    correlations = np.zeros(max(int(distances.max()) + 1, len(positive)))
    correlations[: len(positive)] = positive
    return len(used) ** 2 / float(correlations[distances].sum())


def correlation_time(correlations: Array) -> float:
    """1 + 2 times the sum of correlations by lag (k,), from lag 0 on."""
    return 2 * float(initial_positive(correlations).sum()) - 1


def initial_positive(correlations: Array) -> Array:
    """Correlations up to where two neighbours no longer add up to more than 0.

    Farther out they are chance, whose sum has no limit (initial positive sequence: Geyer,
    Practical Markov Chain Monte Carlo, 1992). nan, of lags without pairs, ends them too.
    """
    pair_sums = correlations[: len(correlations) // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(~(pair_sums > 0))
    return correlations[: 2 * (int(ends[0]) if len(ends) else len(pair_sums))]


def _table(pairs: RangePairs) -> Array:
    """Errors of good returns (scans, rays) about their mean [m]; nan where there is none.

    One return that is far off hides what thousands have in common, and a sensor model takes it for
    false: those by more than ``WILD`` robust standard deviations are left out.
    """
    errors, good = pairs.residuals, pairs.right
    # Where the median is 0, there is nothing wild.
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
    """(2, s, k): by scan the products of errors (s, r) a lag apart, and how many there are.

    Along axis 0 between scans, along axis 1 between rays; nan where there is no error.
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
    """By lag (k,), each scan counted so many times (s,); nan of lags without pairs."""
    products, counts = times @ sums
    with np.errstate(invalid="ignore"):
        covariances = products / counts
    correlations: Array = covariances / covariances[0]
    return correlations


def _blocks(chance: np.random.Generator, scans: int, block: int) -> Array:
    """How often each scan is drawn (s,), in blocks of successive ones around a circle."""
    starts = chance.integers(0, scans, math.ceil(scans / block))
    scans_used = (starts[:, None] + np.arange(block)).ravel()[:scans] % scans
    return np.bincount(scans_used, minlength=scans).astype(np.float64)


def _interval(values: Array) -> Interval:
    low, high = np.percentile(values, [2.5, 97.5]).tolist()
    return low, high
