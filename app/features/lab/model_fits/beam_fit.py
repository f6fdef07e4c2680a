"""Fit the parameters of the beam model by maximum likelihood.

The densities are those of ``robot.localization.models.beam.Beam`` (Probabilistic Robotics, Table
6.1, without its normalisers): z_hit N(z; z*, sigma_hit); z_short lambda_short exp(-lambda_short z)
up to the expected range; z_max, no return where an edge is surely seen; z_rand / range_max.

A likelihood needs a proper distribution. So the model must also cover short and false ranges that
would lie where the ray does not see: before its sight begins, behind the edge, behind the end of
sight. Such a ray goes on as if nothing was in its way, and hits or misses the edge in the ratio
z_hit to z_max. With clear = 1 - (short and false ranges in sight) and miss = z_max /
(z_hit + z_max):

==============================  ======================================================
an edge surely seen, a range    clear (1 - miss) N(z; z*, sigma_hit) + short(z) + z_rand / range_max
an edge surely seen, none       clear miss
no edge in sight, a range       short(z) + z_rand / range_max
no edge in sight, none          clear
==============================  ======================================================

Rays that may or may not see an edge at the border of their sight are left out: what they return
depends on the scanner's geometry and is not random. z_short and z_rand are for a ray that sees
everything up to the longest range; a ray that sees a third of that has a third of the false
returns.
"""

from __future__ import annotations

import math
from dataclasses import astuple, dataclass, replace

import numpy as np

from app.features.lab.model_fits.likelihood import (
    FitError,
    Interval,
    Loss,
    Peak,
    expansion,
    interval_of,
    likeliest,
)
from app.features.lab.model_fits.range_pairs import TO_SD, RangePairs
from robot.geometry import Array

FEWEST_RAYS, FEWEST_HITS = 30, 10
WIDEST = 0.25
"""Largest sigma_hit, as a share of the longest range: beyond it hits look like false ranges."""
LEAST_SIGMA = 1e-6
"""Smallest sigma_hit [m]. Without it, a fit to exact ranges would never end; no range is exact to a
micrometre."""
HARDLY_ANY = 0.5
"""With fewer rays of a kind than this, its share is at its border, 0."""
BEYOND = 1000.0
"""How steeply a ray's minus log-likelihood rises where the shares add up to more than 1."""
COORDINATES = ("z_short", "z_max", "z_rand", "sigma_hit", "lambda_short")
"""Coordinates of the likelihood; z_hit is 1 minus the other shares."""


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


@dataclass(frozen=True, slots=True)
class SensorFit:
    """Fitted values and their intervals."""

    values: SensorValues
    intervals: dict[str, Interval]
    """95 % intervals by name."""
    at_border: tuple[str, ...]
    """Values at a border: shares at 0; sigma_hit at its smallest value; lambda_short if no ray was
    cut short (then the rays do not depend on it), or if it is too small or too large to be
    determined."""
    log_likelihood: float
    iterations: int
    converged: bool
    rays: int
    """Number of fitted rays: those that surely see an edge and those that see none."""


def fit_sensor(
    pairs: RangePairs,
    range_max: float,
    start: SensorValues | None = None,
    *,
    worth: float = 1.0,
    least_sigma: float = 0.0,
) -> SensorFit:
    """Fit the beam model's six parameters.

    Args:
        range_max: longest range [m], the same as for the pairs.
        start: values to start from; None guesses them.
        worth: independent rays that a ray is worth; less makes intervals wider, by its square root.
        least_sigma: smallest sigma_hit [m]; the other values are the likeliest ones with it.

    Raises:
        FitError: there are too few rays, or too few returns from edges.
    """
    _check(pairs)
    loss, least_sigma = beam_loss(pairs, range_max), max(least_sigma, LEAST_SIGMA)
    usable = pairs.sure | pairs.empty
    count, near = int(usable.sum()), float(np.median(pairs.sight[usable, 0]))
    # Short ranges that decay over more than the longest range look uniform. Those that decay over
    # less than a third of the distance to where sight begins would hardly ever be seen.
    rates = 1 / range_max, min(1000 / range_max, 3 / near if near > 0 else math.inf)
    least = np.array([0.0, 0.0, 0.0, least_sigma, rates[0]])
    most = np.array([1.0, 1.0, 1.0, math.inf, rates[1]])
    guess = np.array(astuple(start)[1:]) if start else _guess(pairs, range_max, least_sigma)
    begin = np.clip(guess, least, most)
    peak = likeliest(loss, begin, np.maximum(begin, [1 / count] * 3 + [0.0] * 2), least, most)
    few = peak.place[:3] * count < HARDLY_ANY
    peak = replace(peak, free=peak.free & ~np.array([*few, False, few[0]]))
    sigma = float(peak.place[3])
    intervals = _intervals(loss, peak, rates, worth)
    near = int(np.sum(np.abs(pairs.residuals[pairs.sure]) < 5 * sigma))
    # Chance brings many ranges near to edges; then z_hit may be 0.
    hits = min(near, int(intervals["z_hit"][0] * np.sum(pairs.sure)))
    if hits < FEWEST_HITS or sigma > WIDEST * range_max:
        raise FitError(
            f"no edge is found in the ranges: {hits} seem to be of one, off by {sigma:.3g} m; "
            f"needed are {FEWEST_HITS} or more, off by at most {WIDEST * range_max:.3g} m (are the "
            "poses those of the scans, on this map?)"
        )
    return SensorFit(
        SensorValues(*[1 - float(peak.place[:3].sum()), *peak.place.tolist()]),
        intervals,
        tuple(name for name, item in zip(COORDINATES, peak.free, strict=True) if not item),
        peak.log_likelihood,
        peak.iterations,
        peak.converged,
        count,
    )


def beam_loss(pairs: RangePairs, range_max: float) -> Loss:
    """Return minus the log-likelihood by ``COORDINATES`` (5,), and its slope.

    It is that of the rays that surely see an edge, and of those that see none.
    """
    has_range, usable = pairs.returned, pairs.sure | pairs.empty
    # The m rays that returned come first.
    order = np.concatenate([np.flatnonzero(usable & kind) for kind in (has_range, ~has_range)])
    m, misses = int((usable & has_range).sum()), int((pairs.sure & ~has_range).sum())
    ranges, expected = pairs.measured[order[:m]], pairs.expected[order]
    errors = np.where(pairs.sure[order[:m]], pairs.residuals[order[:m]], np.inf)
    in_front = ranges <= expected[:m]
    begin, far = pairs.sight[order].T
    end, view = np.maximum(np.minimum(expected, far), begin), (far - begin) / range_max

    def loss(place: Array) -> tuple[float, Array]:
        short, none, rand, sigma, rate = place.tolist()
        # Shares beyond 1 are no distribution, and would explain any ranges best.
        beyond = max(short + none + rand - 1, 0.0) * BEYOND * len(order)
        clear_all = max(1 - short - rand, 1e-12)
        miss = min(max(none / clear_all, 1e-300), 1 - 1e-12)
        fades = np.exp(-rate * begin), np.exp(-rate * end)
        # All probabilities stay positive: bad values that the search tries are just unlikely.
        clear = np.maximum(1 - short * (fades[0] - fades[1]) - rand * view, 1e-300)
        fading = np.where(in_front, rate * np.exp(-rate * ranges), 0.0)
        normal = np.exp(-0.5 * np.square(errors / sigma)) / (sigma * math.sqrt(2 * math.pi))
        p = np.maximum(clear[:m] * (1 - miss) * normal + short * fading + rand / range_max, 1e-300)
        value = np.log(p).sum() + np.log(clear[m:]).sum() + misses * math.log(miss)
        by_clear = np.concatenate([(1 - miss) * normal / p, 1 / clear[m:]])
        hits = clear[:m] * by_clear[:m]
        by_miss = (misses / miss - hits.sum() / (1 - miss)) / clear_all
        squares = np.square(np.where(hits > 0, errors, 0.0) / sigma)
        ways = by_clear @ (begin * fades[0] - end * fades[1])
        slope = [
            np.sum(fading / p) - by_clear @ (fades[0] - fades[1]) + by_miss * miss,
            by_miss,
            np.sum(1 / p) / range_max - by_clear @ view + by_miss * miss,
            hits @ (squares - 1) / sigma,
            short * (ways + np.sum(fading * (1 / rate - ranges) / p)),
        ]
        slope[:3] = [item - beyond for item in slope[:3]]
        return -float(value) + beyond**2 / (2 * BEYOND * len(order)), -np.array(slope)

    return loss


def _intervals(
    loss: Loss, peak: Peak, rates: tuple[float, float], worth: float
) -> dict[str, Interval]:
    """Return the intervals by name; for a share at 0, up to where seeing none gets unlikely."""
    covariance = peak.covariance / worth
    hit = 1 - float(peak.place[:3].sum())
    low, high = interval_of(hit, float(covariance[:3, :3].sum()), 1.0)
    intervals: dict[str, Interval] = {}
    for k, name in enumerate(COORDINATES):
        value, most = float(peak.place[k]), 1.0 if k < 3 else math.inf
        if peak.free[k]:
            intervals[name] = interval_of(value, float(covariance[k, k]), most)
        elif k < 3:
            # Without short ranges, all values of lambda_short are equally good.
            places = [np.append(peak.place[:4], item) for item in rates if not peak.free[0]]
            peaks = [expansion(loss, item, peak.units, peak.free) for item in places]
            none = min(max(item.upper_bound_at_zero(k, worth) for item in (peak, *peaks)), 1.0)
            # If another share may be above 0, z_hit may be smaller by as much.
            intervals[name], low = (0.0, none), low * (1 - none)
        else:
            intervals[name] = 0.0, value if name == "sigma_hit" else math.inf
    return {"z_hit": (low, high)} | intervals


def _check(pairs: RangePairs) -> None:
    """Refuse pairs that cannot be fitted."""
    if pairs.sure.sum() < FEWEST_RAYS:
        raise FitError(
            f"{pairs.sure.sum()} rays surely see an edge; needed are {FEWEST_RAYS} or more: "
            "drive where tape is in sight"
        )
    if (hits := int((pairs.sure & pairs.returned).sum())) < FEWEST_HITS:
        raise FitError(
            f"{hits} rays returned something where an edge is; needed are {FEWEST_HITS} or more"
        )


def _guess(pairs: RangePairs, range_max: float, least_sigma: float) -> Array:
    """Guess start values (5,): returns farther than five sigmas from their edge count as false."""
    errors = np.abs(pairs.residuals)
    sigma = max(TO_SD * float(np.median(errors[pairs.sure & pairs.returned])), least_sigma)
    wrong = pairs.returned & (pairs.sure | pairs.empty) & ~(pairs.sure & (errors <= 5 * sigma))
    short = pairs.measured[wrong & (pairs.measured <= pairs.expected)]
    # Each count is one or more: with a share of 0, lambda_short has no slope.
    kinds = np.array([wrong.sum() / 2, (pairs.sure & ~pairs.returned).sum(), wrong.sum() / 2]) + 1
    rate = 1 / float(short.mean()) if short.any() else 5 / range_max
    return np.array([*kinds / ((pairs.sure | pairs.empty).sum() + 4), sigma, rate])
