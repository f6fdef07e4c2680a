"""Intervals from profiles of the beam model's likelihood, for what few rays tell of."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from scipy.optimize import brentq

from app.lab.model_fits.sensor.climb import Climb, climb
from app.lab.model_fits.sensor.mixture import FitRays, Limits, SensorValues

FINE_ENOUGH = 0.02
"""Profiles are this exact."""
ALL = 1 - 1e-6
"""A share this great is too unlikely; there is no need to try."""
STRIDE = math.log(4)
"""Values are tried at such ratios until one is too unlikely."""


@dataclass(frozen=True)
class Profiles:
    """The greatest likelihood where one value is held, against that where none is."""

    rays: FitRays
    top: Climb
    limits: Limits

    def share(self, name: str, drop: float) -> tuple[float, float]:
        """Where z_short or z_rand is so great or small that the log-likelihood falls by ``drop``.

        From 0 if it may be none.
        """
        value, rays = getattr(self.top.values, name), len(self.rays.begin)

        def fall(share: float) -> float:
            return self._share_fall(name, share)

        none = 1e-3 / rays
        low = (_fallen(fall, value, none, drop) if value > none else None) or 0.0
        # A ray tells of its own share at most.
        return low, _fallen(fall, max(value, 0.1 * drop / rays), ALL, drop) or 1.0

    def rate(self, drop: float) -> tuple[float, float]:
        """The same of lambda_short; from 0 or to inf if the rays cannot tell where it falls."""
        begin, (least, most) = self.top.values.lambda_short, self.limits.rate
        low = _fallen(self._rate_fall, begin, least, drop) or 0.0
        return low, _fallen(self._rate_fall, begin, most, drop) or math.inf

    def _share_fall(self, name: str, share: float) -> float:
        """Of the log-likelihood if a share is held.

        Very short ranges, or long ones, may hide a share better than those of the fit.
        """
        values, held = self.top.values, self.limits
        short = name == "z_short"
        limits = replace(held, z_short=share) if short else replace(held, z_rand=share)
        start = limits.within(values)
        rates = {values.lambda_short, *(held.rate if short else ())}
        return min(self._fall(replace(start, lambda_short=rate), limits) for rate in rates)

    def _rate_fall(self, rate: float) -> float:
        """Of the log-likelihood if lambda_short is held."""
        start = replace(self.top.values, lambda_short=rate)
        return self._fall(start, replace(self.limits, rate=(rate, rate)))

    def _fall(self, start: SensorValues, limits: Limits) -> float:
        found = climb(self.rays, start, limits, FINE_ENOUGH)
        return self.top.counts.log_likelihood - found.counts.log_likelihood


def _fallen(
    profile: Callable[[float], float], begin: float, end: float, drop: float
) -> float | None:
    """Where on the way from one value to another a profile has fallen by so much; None if not."""

    def height(log_value: float) -> float:
        return drop - profile(math.exp(log_value))

    if begin == end:
        return None
    reached, last = math.log(begin), math.log(end)
    if end != ALL and height(last) > 0:
        return None
    while reached != last:
        way = last - reached
        ahead = last if abs(way) <= STRIDE else reached + math.copysign(STRIDE, way)
        if height(ahead) <= 0:
            return math.exp(brentq(height, reached, ahead, xtol=0.03))
        reached = ahead
    return None
