"""How far the rays of a scan err together, and how many independent ones they are worth."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

from app.lab.model_fits.sensor.range_pairs import RangePairs
from app.lab.model_fits.sensor.range_statistics import TO_SD
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


class CorrelationError(ValueError):
    """Rays of which no correlation can be told; the message says what is needed."""


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
    used: int
    """Rays of a scan that a filter uses: n."""
    independent: float
    """Rays that those are worth: n_eff."""
    independent_interval: tuple[float, float]
    scans_a_new_one: float
    """Successive scans that are worth one independent scan: 1 + 2 times the sum of ``by_scan``."""
    scans_interval: tuple[float, float]
    weight_of_successive: float
    """``likelihood_weight`` if a filter counts every scan: ``weight`` over ``scans_a_new_one``.

    Rays that are so many rays and so many scans apart are taken to be as correlated as the product
    of both correlations.
    """
    weight_of_successive_interval: tuple[float, float]

    @property
    def weight(self) -> float:
        """``likelihood_weight`` if scans err independently: n_eff / n, 1 at most."""
        return min(self.independent / self.used, 1.0)

    @property
    def weight_interval(self) -> tuple[float, float]:
        """Of ``weight``."""
        low, high = self.independent_interval
        return min(low / self.used, 1.0), min(high / self.used, 1.0)


def correlate_beams(
    pairs: RangePairs,
    max_beams: int,
    *,
    gate: float | None = None,
    resamples: int = RESAMPLES,
    seed: int = 0,
) -> BeamCorrelation:
    """Correlation of the errors of good returns; the rest is left out as if not measured.

    One return that is far off hides what thousands have in common, and a sensor model takes it for
    false: those beyond a gate are left out.

    The mean error over everything is taken off, not that of each scan: what a whole scan is off by
    is what its rays are off by together.

    Args:
        pairs: measured and exact ranges of scans that all have the same rays, in their order.
        max_beams: rays that a filter uses of a scan, evenly spread (``robot.scan.evenly``).
        gate: greatest error of a good return [m]; None is ``WILD`` robust standard deviations,
            ``FAR_OFF`` at most.
        resamples: of the bootstrap.
        seed: of the bootstrap.

    Raises:
        CorrelationError: too few scans, or no two rays that returned what they should.
    """
    table = _table(pairs, gate)
    scans, rays = table.shape
    most = int(np.isfinite(table).sum(axis=1).max(initial=0))
    if scans < FEWEST_SCANS or most < 2:
        raise CorrelationError(
            f"{scans} scans with at most {most} returns from edges in one; needed are "
            f"{FEWEST_SCANS} scans or more, and two returns in one"
        )
    along = LagSums.of(table, rays, _along_rays)
    across = LagSums.of(table, min(scans // 2, LONGEST), _along_scans)
    used, chance = evenly(rays, max_beams), np.random.default_rng(seed)
    every = np.ones(scans)
    by_ray, by_scan = along.correlations(every), across.correlations(every)
    independent, together = independent_rays(by_ray, used), correlation_time(by_scan)
    block = min(math.ceil(2 * together), scans // 2)
    draws = [_blocks(chance, scans, block) for _ in range(resamples)]
    worth = np.array([independent_rays(along.correlations(times), used) for times in draws])
    times_apart = np.array([correlation_time(across.correlations(times)) for times in draws])
    return BeamCorrelation(
        by_ray,
        by_scan,
        len(used),
        independent,
        _interval(worth),
        together,
        _interval(times_apart),
        _share(independent, len(used), together),
        _interval(_share(worth, len(used), times_apart)),
    )


@overload
def _share(independent: float, used: int, together: float) -> float: ...
@overload
def _share(independent: Array, used: int, together: Array) -> Array: ...
def _share(independent: float | Array, used: int, together: float | Array) -> float | Array:
    return np.minimum(independent / (used * np.maximum(together, 1.0)), 1.0)


def independent_rays(by_ray: Array, used: NDArray[np.intp]) -> float:
    """How many independent rays some rays of a scan are worth: n^2 / (sum of all correlations).

    For n neighbours that is n / (1 + 2 sum of (1 - k / n) rho_k), k = 1 to n - 1.

    Args:
        by_ray: (k,) correlation by lag of rays, from lag 0 on.
        used: (n,) numbers of the rays.
    """
    known = initial_positive(by_ray)
    apart = np.abs(used[:, None] - used[None, :]).ravel()
    correlations = np.zeros(max(int(apart.max()) + 1, len(known)))
    correlations[: len(known)] = known
    return len(used) ** 2 / float(correlations[apart].sum())


def correlation_time(correlations: Array) -> float:
    """1 + 2 times the sum of correlations by lag (k,), from lag 0 on."""
    return 2 * float(initial_positive(correlations).sum()) - 1


def initial_positive(correlations: Array) -> Array:
    """Correlations up to where two neighbours no longer add up to more than 0.

    Farther out they are chance, whose sum has no limit (initial positive sequence: Geyer,
    Practical Markov Chain Monte Carlo, 1992). nan, of lags without pairs, ends them too.
    """
    known = correlations[: len(correlations) // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(~(known > 0))
    return correlations[: 2 * (int(ends[0]) if len(ends) else len(known))]


@dataclass(frozen=True)
class LagSums:
    """Sums over the pairs of errors that lie a lag apart, by scan (s, k), lags 0 to k - 1."""

    products: Array
    sums: Array
    counts: Array

    @classmethod
    def of(
        cls, table: Array, lags: int, shifted: Callable[[Array, int], tuple[Array, Array]]
    ) -> LagSums:
        """Of a table (s, r) of errors, nan where there is none."""
        known = np.isfinite(table)
        errors, there = np.where(known, table, 0.0), known.astype(np.float64)
        result = np.zeros((3, len(table), lags))
        for lag in range(lags):
            (first, second), (one, other) = shifted(errors, lag), shifted(there, lag)
            scans = len(first)
            result[0, :scans, lag] = np.einsum("ij,ij->i", first, second)
            result[1, :scans, lag] = np.einsum("ij,ij->i", first, other)
            result[1, :scans, lag] += np.einsum("ij,ij->i", one, second)
            result[2, :scans, lag] = np.einsum("ij,ij->i", one, other)
        return cls(*result)

    def correlations(self, times: Array) -> Array:
        """By lag (k,), each scan counted so many times (s,); nan of lags without pairs."""
        products, sums, counts = times @ self.products, times @ self.sums, times @ self.counts
        mean = sums[0] / (2 * counts[0])
        with np.errstate(invalid="ignore"):
            covariances = (products - mean * sums) / counts + mean**2
        if not covariances[0] > LEAST_SD**2:
            raise CorrelationError("all ranges are off by the same; needed are errors that differ")
        correlations: Array = covariances / covariances[0]
        return correlations


def _along_rays(table: Array, lag: int) -> tuple[Array, Array]:
    return table[:, : table.shape[1] - lag], table[:, lag:]


def _along_scans(table: Array, lag: int) -> tuple[Array, Array]:
    return table[: len(table) - lag], table[lag:]


def _table(pairs: RangePairs, gate: float | None) -> Array:
    """Errors of good returns (scans, rays) [m]; nan where there is none."""
    right = pairs.right
    errors = np.abs(pairs.residuals)
    if gate is None:
        # Where errors are all 0, or the median is, there is nothing wild.
        gate = WILD * TO_SD * float(np.median(errors[right])) if right.any() else 0.0
        gate = gate or math.inf
    good = right & (errors <= gate)
    shape = (int(pairs.scan.max(initial=-1)) + 1, int(pairs.ray.max(initial=-1)) + 1)
    table = np.full(shape, np.nan)
    table[pairs.scan[good], pairs.ray[good]] = pairs.residuals[good]
    return table


def _blocks(chance: np.random.Generator, scans: int, block: int) -> Array:
    """How often each scan is drawn (s,), in blocks of successive ones around a circle."""
    starts = chance.integers(0, scans, math.ceil(scans / block))
    drawn = (starts[:, None] + np.arange(block)).ravel()[:scans] % scans
    return np.bincount(drawn, minlength=scans).astype(np.float64)


def _interval(values: Array) -> tuple[float, float]:
    low, high = np.percentile(values, [2.5, 97.5]).tolist()
    return low, high
