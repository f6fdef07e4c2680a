"""The beam model as a distribution that ranges are drawn from, and one step of its fit."""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import xlogy

from app.lab.model_fits.sensor.range_pairs import RangePairs
from robot.geometry import Array

LEAST_SIGMA = 1e-6
"""Ranges are nowhere exact to more than a micrometre; without an end the fit of some that are
would never end [m]."""
SHARES = ("z_hit", "z_short", "z_max", "z_rand")


@dataclass(frozen=True, slots=True)
class SensorValues:
    """One number for each parameter of the beam model; the four shares add up to 1."""

    z_hit: float
    z_short: float
    z_max: float
    z_rand: float
    sigma_hit: float
    """[m]"""
    lambda_short: float
    """[1/m]"""


@dataclass(frozen=True)
class FitRays:
    """The rays of a fit: n of them, of which the first m returned something."""

    ranges: Array
    """(m,) [m]"""
    off: Array
    """(m,) measured minus expected [m]; 0 where nothing was expected."""
    facing: NDArray[np.bool_]
    """(m,) whether an edge was expected."""
    before: NDArray[np.bool_]
    """(m,) whether the range is no longer than expected."""
    missed: int
    """Rays that surely see an edge and returned nothing."""
    begin: Array
    """(n,) from where on a range can be cut short [m]: where sight begins."""
    end: Array
    """(n,) up to where: the expected edge, or where sight ends [m]."""
    seen: Array
    """(n,) length of the ray's sight, as a share of the longest range."""
    range_max: float
    """[m]"""

    @classmethod
    def of(cls, pairs: RangePairs, range_max: float) -> FitRays:
        """Those that surely see an edge, and those that see none."""
        sure, empty, returned = pairs.sure, pairs.empty, pairs.returned
        fitted = sure | empty
        order = np.concatenate([np.flatnonzero(fitted & kind) for kind in (returned, ~returned)])
        count = int((fitted & returned).sum())
        first = order[:count]
        near, far = pairs.sight[order].T
        return cls(
            ranges=pairs.measured[first],
            off=np.where(sure[first], pairs.residuals[first], 0.0),
            facing=sure[first],
            before=pairs.measured[first] <= pairs.expected[first],
            missed=int((sure & ~returned).sum()),
            begin=near,
            end=np.maximum(np.minimum(pairs.expected[order], far), near),
            seen=(far - near) / range_max,
            range_max=range_max,
        )


@dataclass(frozen=True, slots=True)
class Counts:
    """What the rays are worth for each parameter, were the given values true (expectation)."""

    log_likelihood: float
    on: float
    """Rays that nothing came in the way of; ``on``, ``short`` and ``rand`` add up to all rays."""
    short: float
    """Rays that were to be cut short, also if that was to be out of sight."""
    rand: float
    """Rays that were to be false, also if that was to be out of sight."""
    hit: float
    """Returns from the expected edge."""
    missed: float
    """Rays that missed it."""
    square: float
    """Sum of squared errors of the returns from the edge [m²]."""
    way: float
    """Sum of the ways of the rays that were to be cut short [m]."""
    returned_short: float
    """Those of ``short`` that returned."""
    returned_rand: float
    """Those of ``rand`` that returned."""


def expect(rays: FitRays, values: SensorValues) -> Counts:
    """Expectation step, with the exact log-likelihood at the values.

    See ``fit`` for the distribution.
    """
    z_hit, z_short, z_max, z_rand, sigma, rate = astuple(values)
    m, on = len(rays.ranges), z_hit + z_max
    from_begin, from_end = np.exp(-rate * rays.begin), np.exp(-rate * rays.end)
    hidden = 1.0 - (from_begin - from_end)
    goes_on = on + z_short * hidden + z_rand * (1.0 - rays.seen)
    hits = _normal(rays, sigma) * goes_on[:m] * (z_hit / on)
    shorts = np.where(rays.before, z_short * rate * np.exp(-rate * rays.ranges), 0.0)
    false = z_rand / rays.range_max
    # Never 0, so that values tried in vain are merely unlikely.
    p = np.maximum(hits + shorts + false, 1e-300)
    hit, short = hits / p, shorts / p
    # Of the rays that went on: the share that nothing was to come in the way of, by 1 / on.
    went_on = np.concatenate([hit, np.ones(len(rays.begin) - m)]) / goes_on
    hidden_way = 1 / rate - (rays.begin + 1 / rate) * from_begin + (rays.end + 1 / rate) * from_end
    returned_short, returned_rand = float(short.sum()), false * float((1.0 / p).sum())
    return Counts(
        log_likelihood=float(
            np.log(p).sum() + np.log(goes_on[m:]).sum() + xlogy(rays.missed, z_max / on)
        ),
        on=on * float(went_on.sum()),
        short=returned_short + z_short * float(went_on @ hidden),
        rand=returned_rand + z_rand * float(went_on @ (1.0 - rays.seen)),
        hit=float(hit.sum()),
        missed=float(rays.missed),
        square=float(hit @ np.square(rays.off)),
        way=float(short @ rays.ranges) + z_short * float(went_on @ hidden_way),
        returned_short=returned_short,
        returned_rand=returned_rand,
    )


def _normal(rays: FitRays, sigma: float) -> Array:
    """Density (m,) of the returns, were they from the expected edge; 0 without one [1/m]."""
    density = np.exp(-0.5 * np.square(rays.off / sigma)) / (sigma * math.sqrt(2 * math.pi))
    return np.where(rays.facing, density, 0.0)


@dataclass(frozen=True, slots=True)
class Limits:
    """What a fit may not change, or only so far."""

    rate: tuple[float, float]
    """Least and greatest lambda_short [1/m]."""
    sigma: float = LEAST_SIGMA
    """Least sigma_hit [m]."""
    z_short: float | None = None
    """Held at this."""
    z_rand: float | None = None
    """Held at this."""

    @classmethod
    def of(cls, rays: FitRays, sigma: float) -> Limits:
        """As far as the rays can tell.

        Short ranges that get rarer over more than the longest range are as good as even. Those
        that do over a third of the way to where sight begins would hardly ever be seen.
        """
        near = float(np.median(rays.begin))
        most = 1000 / rays.range_max
        most = min(most, 3 / near) if near > 0 else most
        return cls((1 / rays.range_max, most), max(sigma, LEAST_SIGMA))

    def within(self, values: SensorValues) -> SensorValues:
        """The nearest values within the limits, with shares that add up to 1."""
        on = values.z_hit + values.z_max
        straight = values.z_hit / on
        on, z_short, z_rand = self.shares(on, values.z_short, values.z_rand)
        return SensorValues(
            on * straight,
            z_short,
            on * (1 - straight),
            z_rand,
            max(values.sigma_hit, self.sigma),
            min(max(values.lambda_short, self.rate[0]), self.rate[1]),
        )

    def shares(self, on: float, short: float, rand: float) -> tuple[float, float, float]:
        """Shares that are as these numbers of rays, but for those that are held."""
        if self.z_short is not None:
            rest = (1 - self.z_short) / (on + rand)
            return on * rest, self.z_short, rand * rest
        if self.z_rand is not None:
            rest = (1 - self.z_rand) / (on + short)
            return on * rest, short * rest, self.z_rand
        total = on + short + rand
        return on / total, short / total, rand / total


def maximize(counts: Counts, limits: Limits, rate: float) -> SensorValues:
    """Maximization step.

    Args:
        counts: of the expectation step.
        limits: of the values.
        rate: lambda_short of before, which stays if no ray was cut short.
    """
    straight = counts.hit / (counts.hit + counts.missed)
    return limits.within(
        SensorValues(
            counts.on * straight,
            counts.short,
            counts.on * (1 - straight),
            counts.rand,
            math.sqrt(counts.square / counts.hit),
            counts.short / counts.way if counts.way > 0 else rate,
        )
    )
