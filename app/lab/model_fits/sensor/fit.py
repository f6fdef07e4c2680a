"""Parameters of the beam model fitted to ranges by expectation maximization.

After Probabilistic Robotics, Table 6.2 (learn_intrinsic_parameters), for the densities that
``robot.localization.models.beam.Beam`` has (there they are the book's without its normalisers):

- z_hit: normal about the expected range, with sigma_hit;
- z_short: lambda_short exp(-lambda_short z), up to the expected range;
- z_max: no return where an edge is surely seen;
- z_rand: 1 / range_max everywhere.

To be a distribution that all this is drawn from, it has to say what becomes of a short or a false
range that would lie where the ray does not see: before its sight begins, behind the edge, behind
the end of sight. Such a ray goes on as if nothing had come in its way, to hit the edge or to miss
it by z_hit to z_max. With on = 1 - (short and false ranges in sight) and h = z_hit /
(z_hit + z_max):

==============================  ===================================================
an edge surely seen, a range    on h N(z; z*, sigma_hit) + short(z) + z_rand / range_max
an edge surely seen, none       on (1 - h)
no edge in sight, a range       short(z) + z_rand / range_max
no edge in sight, none          on
==============================  ===================================================

So rays without an edge in sight tell of z_short, lambda_short and z_rand alone, by what they
return and by what they do not. Rays that may or may not see an edge at the border of their sight
are left out: what they return depends on the scanner's geometry, which is no chance. z_short and
z_rand are for a ray that sees everything up to the longest range; a ray that sees a third of that
has a third of the false returns. The density of false ranges by the metre is thus what ``Beam``
takes it for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from app.lab.model_fits.fit_error import FitError
from app.lab.model_fits.sensor.climb import climb
from app.lab.model_fits.sensor.intervals import Intervals, intervals
from app.lab.model_fits.sensor.mixture import FitRays, Limits, SensorValues
from app.lab.model_fits.sensor.range_pairs import RangePairs
from app.lab.model_fits.sensor.range_statistics import TO_SD

FEWEST_RAYS = 30
FEWEST_HITS = 10
WIDEST = 0.25
"""A spread by more of the longest range is none: hits are not told from false ranges."""


@dataclass(frozen=True, slots=True)
class SensorFit:
    """Fitted values and how sure they are."""

    values: SensorValues
    standard_errors: SensorValues
    """nan for values at a border."""
    low: SensorValues
    """Where 95 % intervals begin."""
    high: SensorValues
    """Where they end."""
    at_border: tuple[str, ...]
    """Values at the border of what they can be: shares at 0; sigma_hit at its least; lambda_short
    if no ray was cut short (the rays say nothing of it), or if it is so small or great that it
    cannot be told."""
    log_likelihoods: tuple[float, ...]
    """At the start and after each iteration; never falling."""
    converged: bool
    rays: int
    """Rays that were fitted: those that surely see an edge and those that see none."""
    range_max: float
    """[m]"""

    @property
    def iterations(self) -> int:
        """Steps until it converged."""
        return len(self.log_likelihoods) - 1

    def interval(self, name: str) -> tuple[float, float]:
        """The 95 % interval of a value."""
        return getattr(self.low, name), getattr(self.high, name)


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
        pairs: measured and exact ranges.
        range_max: longest range [m], as the pairs were made for.
        start: values to start from; None guesses them.
        worth: how many independent rays one ray is worth (``beam_correlation``): intervals get
            wider by its root. The values are the same.
        least_sigma: sigma_hit is not fitted below it [m]. Settings have a least one too: the other
            values are then those that are the likeliest with it.

    Raises:
        FitError: too few rays, too few returns from edges, numbers that are no ranges; or start
            values or a worth that cannot be.
    """
    _check(pairs, range_max, start, worth)
    rays = FitRays.of(pairs, range_max)
    limits = Limits.of(rays, least_sigma)
    top = climb(rays, start or _guess(rays, limits), limits)
    if top.counts.hit < FEWEST_HITS or top.values.sigma_hit > WIDEST * range_max:
        raise FitError(
            f"no edge is found in the ranges: {top.counts.hit:.0f} seem to be of one, off by "
            f"{top.values.sigma_hit:.3g} m; needed are {FEWEST_HITS} or more, off by at most "
            f"{WIDEST * range_max:.3g} m (are the poses those of the scans, on this map?)"
        )
    sure: Intervals = intervals(rays, top, limits, worth)
    return SensorFit(
        top.values,
        sure.standard_errors,
        sure.low,
        sure.high,
        sure.at_border,
        top.log_likelihoods,
        top.converged,
        len(rays.begin),
        range_max,
    )


def _check(pairs: RangePairs, range_max: float, start: SensorValues | None, worth: float) -> None:
    """Refuse what cannot be fitted."""
    if not (0 < range_max < math.inf and 0 < worth <= 1):
        raise FitError(
            f"range_max is {range_max}, worth {worth}; valid are a length in metres, and a share "
            "above 0, up to 1"
        )
    if np.isnan(pairs.measured).any() or np.isnan(pairs.expected).any():
        raise FitError("some ranges are nan; valid are metres, or inf for none")
    if (pairs.measured < 0).any() or (pairs.measured[pairs.returned] > range_max).any():
        raise FitError(f"some ranges are not within 0 and range_max, {range_max} m")
    if pairs.sure.sum() < FEWEST_RAYS:
        raise FitError(
            f"{pairs.sure.sum()} rays surely see an edge; needed are {FEWEST_RAYS} or more: "
            "drive where tape is in sight"
        )
    if (hits := int((pairs.sure & pairs.returned).sum())) < FEWEST_HITS:
        raise FitError(
            f"{hits} rays returned something where an edge is; needed are {FEWEST_HITS} or more"
        )
    if start is not None and not _can_start(start):
        raise FitError(
            f"{start} is no start; valid are shares above 0 that add up to 1, and a spread and a "
            "rate above 0"
        )


def _can_start(start: SensorValues) -> bool:
    shares = (start.z_hit, start.z_short, start.z_max, start.z_rand)
    positive = min(*shares, start.sigma_hit, start.lambda_short) > 0
    return positive and math.isclose(sum(shares), 1.0, abs_tol=1e-6)


def _guess(rays: FitRays, limits: Limits) -> SensorValues:
    """Values to start from: what is farther than five spreads from its edge is false."""
    off = rays.off[rays.facing]
    sigma = max(TO_SD * float(np.median(np.abs(off))), limits.sigma)
    right = np.zeros(len(rays.ranges), dtype=np.bool_)
    right[rays.facing] = np.abs(off) <= 5 * sigma
    short = rays.ranges[rays.before & ~right]
    false = len(right) - int(right.sum())
    # None is nothing, for what is nothing at the start stays so.
    counts = [right.sum() + 1.0, false / 2 + 1.0, rays.missed + 1.0, false / 2 + 1.0]
    z_hit, z_short, z_max, z_rand = (float(count / sum(counts)) for count in counts)
    rate = 1 / float(short.mean()) if len(short) and short.any() else 5 / rays.range_max
    rate = min(max(rate, limits.rate[0]), limits.rate[1])
    return SensorValues(z_hit, z_short, z_max, z_rand, sigma, rate)
