"""Find the maximum of a likelihood, and 95 % intervals from its curvature, for all fits."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, minimize

from robot.errors import BrickPoseError
from robot.geometry import Array

NORMAL_95 = 1.959964
"""95 % of a normal distribution lie within this many standard deviations."""
NONE_SEEN = math.log(20)
"""If none was seen, the share is at most the one with which seeing none has a chance of 5 % (rule
of three)."""
WELL_KNOWN = 0.5
"""Up to this standard deviation of its logarithm, a value's logarithm is taken as normal."""
FLAT = 1e-9
"""A likelihood with less curvature than this, in units of its values, determines nothing."""
AT_BORDER = 1e-6
"""A value this near to a border, in units of the values, is at the border."""
STEP = 1e-4
"""Step of the finite differences of slopes that give the curvature, as a share of a value."""

Interval = tuple[float, float]
Loss = Callable[[Array], tuple[float, Array]]
"""Minus the log-likelihood at a point (k,), and its slope there (k,)."""


class FitError(BrickPoseError, ValueError):
    """The data are not enough for the fit; the message says what is needed."""


@dataclass(frozen=True, eq=False)
class Peak:
    """The maximum of a likelihood, and its second-order expansion there."""

    place: Array
    """(k,) the values at the maximum."""
    units: Array
    """(k,): typical sizes of the values, or of their changes."""
    log_likelihood: float
    slope: Array
    """(k,) of minus the log-likelihood: not 0 for values at a border."""
    information: Array
    """(k, k): second derivatives of minus the log-likelihood."""
    free: NDArray[np.bool_]
    """(k,): whether a value is at no border."""
    iterations: int

    @property
    def converged(self) -> bool:
        """Whether the log-likelihood could rise by less than a thousandth."""
        return float(self.slope @ self.covariance @ self.slope) / 2 < 1e-3

    @property
    def covariance(self) -> Array:
        """(k, k) of the values, taken as normal about the maximum; 0 for those at a border."""
        inner = np.ix_(self.free, self.free)
        inner_bends, covariance = self.information[inner], np.zeros_like(self.information)
        sizes = np.outer(self.units, self.units)[inner]
        values, axes = np.linalg.eigh(inner_bends * sizes)
        # Directions that the data do not determine get huge variances.
        covariance[inner] = (axes / np.maximum(values, FLAT)) @ axes.T * sizes
        return covariance

    def upper_bound_at_zero(self, k: int, worth: float = 1.0) -> float:
        """Return how large a value at its lower border, 0, may be, by the rule of three.

        It is where the parabola of the log-likelihood, with the free values at their best, has
        fallen by ``NONE_SEEN``; the tangent is used if the parabola bends upwards. The worth is the
        weight of each datum, less than 1 if data repeat themselves.
        """
        row = self.information[k]
        bend = max(float(row[k] - row @ self.covariance @ row), 0.0)
        slope, fall = max(float(self.slope[k]), 1e-300), NONE_SEEN / worth
        return 2 * fall / (slope + math.sqrt(slope**2 + 2 * bend * fall))


def likeliest(loss: Loss, start: Array, units: Array, least: Array, most: Array) -> Peak:
    """Find the maximum of a likelihood.

    Args:
        loss: minus the log-likelihood and its slope.
        start: (k,) where to begin.
        units: (k,) typical sizes of the values, or of their changes.
        least: (k,) smallest values.
        most: (k,) largest values.
    """

    def scaled(place: Array) -> tuple[float, Array]:
        value, slope = loss(place * units)
        return value, slope * units

    begin, limits = start / units, Bounds(least / units, most / units)
    options: Any = {"maxfun": 5000, "ftol": 1e-7, "xtol": 1e-9}
    options |= {"scale": np.ones(len(units)), "offset": begin}
    # L-BFGS-B takes ten times as long with its small matrices on busy cores.
    result = minimize(scaled, begin, jac=True, method="TNC", bounds=limits, options=options)
    place: Array = result.x * units
    free = np.ones(len(place), dtype=np.bool_)
    for border in (least, most):
        at_end = np.abs(place - border) < AT_BORDER * units
        place[at_end], free[at_end] = border[at_end], False
    return expansion(loss, place, units, free, int(result.nit))


def expansion(
    loss: Loss,
    place: Array,
    units: Array,
    free: NDArray[np.bool_],
    iterations: int = 0,
) -> Peak:
    """Expand a likelihood about a point (k,); see ``likeliest`` and ``Peak`` for the arguments.

    The curvature comes from differences of the slope; these keep values from going below 0.
    """
    value, slope = loss(place)
    columns = []
    for k, step in enumerate(STEP * np.maximum(np.abs(place), 0.01 * units)):
        ahead, behind = place.copy(), place.copy()
        ahead[k], behind[k] = place[k] + step, max(place[k] - step, min(place[k], 0.0))
        columns.append((loss(ahead)[1] - loss(behind)[1]) / (ahead[k] - behind[k]))
    curvature = np.array(columns)
    return Peak(place, units, -value, slope, (curvature + curvature.T) / 2, free, iterations)


def interval_of(value: float, variance: float, most: float = math.inf) -> Interval:
    """Return the 95 % interval of a value between 0 and its largest possible value.

    If the value is well known, its logarithm is taken as normal, or its log-odds if there is a
    largest value. Else the value itself is taken as normal; then the interval may begin at 0, and
    it ends like that of a value at 0.
    """
    deviation, slope = math.sqrt(variance), value * (1 - value / most)
    if deviation >= WELL_KNOWN * slope:
        ends = value - NORMAL_95 * deviation, value + math.sqrt(2 * NONE_SEEN) * deviation
        return max(ends[0], 0.0), min(ends[1], most)
    odds, factor = value / (1 - value / most), math.exp(NORMAL_95 * deviation / slope)
    low, high = odds / factor, odds * factor
    return low / (1 + low / most), high / (1 + high / most)
