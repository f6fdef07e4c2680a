"""What every fit shares: where a likelihood is greatest, and 95 % intervals from its curvature."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, minimize

from robot.geometry import Array

NORMAL_95 = 1.959964
"""95 % of a normal distribution lie within so many standard deviations."""
NONE_SEEN = math.log(20)
"""What is not there may be so great that seeing none had a chance of 5 %: the rule of three."""
WELL_KNOWN = 0.5
"""Up to this standard deviation of its logarithm, a value's logarithm is taken as normal."""
FLAT = 1e-9
"""A likelihood that is bent less, by the units of its values, tells nothing."""
AT_BORDER = 1e-6
"""So near to a border, in units of the values, is at it."""
STEP = 1e-4
"""Of the differences of slopes that make the curvature, as a share of a value."""

Interval = tuple[float, float]
Loss = Callable[[Array], tuple[float, Array]]
"""Minus the logarithm of the likelihood at a place (k,), and its slope there (k,)."""


class FitError(ValueError):
    """The data do not tell what is asked of them; the message says what is needed."""


@dataclass(frozen=True, eq=False)
class Peak:
    """Where a likelihood is greatest, and its second-order expansion there."""

    place: Array
    """(k,)"""
    units: Array
    """(k,): about how great values are, or how much they change."""
    log_likelihood: float
    slope: Array
    """(k,) of minus the log-likelihood: not 0 where the place is at a border."""
    information: Array
    """(k, k): second derivatives of minus the log-likelihood."""
    free: NDArray[np.bool_]
    """(k,): values that are at no border."""
    iterations: int

    @property
    def converged(self) -> bool:
        """Whether the likelihood's logarithm would rise by less than a thousandth."""
        return float(self.slope @ self.covariance @ self.slope) / 2 < 1e-3

    @property
    def covariance(self) -> Array:
        """(k, k) of the values, normal about the place; 0 for those at a border."""
        inner = np.ix_(self.free, self.free)
        inner_bends, covariance = self.information[inner], np.zeros_like(self.information)
        sizes = np.outer(self.units, self.units)[inner]
        values, axes = np.linalg.eigh(inner_bends * sizes)
        # Where nothing is known, variances are immense.
        covariance[inner] = (axes / np.maximum(values, FLAT)) @ axes.T * sizes
        return covariance

    def none_seen(self, k: int, worth: float = 1.0) -> float:
        """How great a value may be that is at its least border, 0: by the rule of three.

        Where the parabola of the likelihood, the free values at their best, has fallen by
        ``NONE_SEEN``, or its tangent if it is bent the other way. Of data that repeat themselves
        each counts its worth.
        """
        row = self.information[k]
        bend = max(float(row[k] - row @ self.covariance @ row), 0.0)
        slope, fall = max(float(self.slope[k]), 1e-300), NONE_SEEN / worth
        return 2 * fall / (slope + math.sqrt(slope**2 + 2 * bend * fall))


def likeliest(loss: Loss, start: Array, units: Array, least: Array, most: Array) -> Peak:
    """Find where a likelihood is greatest.

    Args:
        loss: minus the log-likelihood and its slope.
        start: (k,) where to begin.
        units: (k,) about how great values are, or how much they change.
        least: (k,) least values.
        most: (k,) greatest values.
    """

    def scaled(place: Array) -> tuple[float, Array]:
        value, slope = loss(place * units)
        return value, slope * units

    begin, limits = start / units, Bounds(least / units, most / units)
    options: Any = {"maxfun": 5000, "ftol": 1e-7, "xtol": 1e-9}
    options |= {"scale": np.ones(len(units)), "offset": begin}
    # L-BFGS-B takes ten times as long where its small matrices meet busy cores.
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
    """A likelihood about a place (k,); the arguments are those of ``likeliest`` and ``Peak``.

    The curvature is of differences of the slope; a value is not taken below 0 for that.
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
    """95 % interval of a value from 0 to the most that it can be.

    Its logarithm, or log-odds if it has a most, is taken as normal where it is well known; else
    the value itself is, the interval may begin at 0, and ends as that of a value at 0 does.
    """
    deviation, slope = math.sqrt(variance), value * (1 - value / most)
    if deviation >= WELL_KNOWN * slope:
        ends = value - NORMAL_95 * deviation, value + math.sqrt(2 * NONE_SEEN) * deviation
        return max(ends[0], 0.0), min(ends[1], most)
    odds, factor = value / (1 - value / most), math.exp(NORMAL_95 * deviation / slope)
    low, high = odds / factor, odds * factor
    return low / (1 + low / most), high / (1 + high / most)
