"""How measured ranges differ from exact ones, by distance and by bearing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from app.lab.model_fits.sensor.range_pairs import RangePairs
from robot.geometry import Array

TO_SD = 1.4826
"""Standard deviation of a normal distribution by its median absolute deviation."""


@dataclass(frozen=True, slots=True)
class RangeStatistics:
    """The rays of one bin. A figure of which there is nothing to tell is nan."""

    low: float
    """Of the bin [m] or [rad]."""
    high: float
    count: int
    """Rays that returned what they should, within ``FAR_OFF``: bias and spread are of these."""
    bias: float
    """Mean of measured minus exact [m]."""
    sd: float
    """Standard deviation of it [m]."""
    robust_sd: float
    """1.4826 times the median absolute deviation [m]: what it is without the worst ones."""
    expected: int
    """Rays that surely see an edge."""
    missed: float
    """Share of those that do not report it: no return, or one that is false."""
    returns: int
    """Rays that returned anything."""
    false: float
    """Share of those where nothing is: farther than ``FAR_OFF`` from the edge, or without one."""


def by_distance(pairs: RangePairs, borders: Array) -> list[RangeStatistics]:
    """Statistics between borders (k + 1,) [m], rising.

    What should have been seen counts by its exact distance, what was returned by its measured one.
    """
    return [
        _statistics(pairs, low, high, _between(pairs.expected, low, high), returned)
        for low, high in _bins(borders)
        for returned in [_between(pairs.measured, low, high)]
    ]


def by_bearing(pairs: RangePairs, borders: Array) -> list[RangeStatistics]:
    """Statistics between borders (k + 1,) of bearings [rad], rising."""
    return [
        _statistics(pairs, low, high, within, within)
        for low, high in _bins(borders)
        for within in [_between(pairs.bearings, low, high)]
    ]


def overall(pairs: RangePairs) -> RangeStatistics:
    """Statistics of all rays."""
    everywhere = np.ones(len(pairs), dtype=np.bool_)
    return _statistics(pairs, -math.inf, math.inf, everywhere, everywhere)


def _bins(borders: Array) -> list[tuple[float, float]]:
    """Neighbouring borders.

    Raises:
        ValueError: fewer than two, or not rising.
    """
    if len(borders) < 2 or not (np.diff(borders) > 0).all():
        raise ValueError(f"borders are {borders}; valid are two or more that rise")
    return list(zip(borders[:-1].tolist(), borders[1:].tolist(), strict=True))


def _between(values: Array, low: float, high: float) -> NDArray[np.bool_]:
    """From the low border on to before the high one."""
    return (low <= values) & (values < high)


def _statistics(
    pairs: RangePairs,
    low: float,
    high: float,
    by_expected: NDArray[np.bool_],
    by_measured: NDArray[np.bool_],
) -> RangeStatistics:
    right = pairs.right
    off = pairs.residuals[right & by_expected]
    sure, returned = pairs.sure & by_expected, pairs.returned & by_measured
    middle = np.median(off) if len(off) else math.nan
    return RangeStatistics(
        low,
        high,
        count=len(off),
        bias=float(off.mean()) if len(off) else math.nan,
        sd=float(off.std(ddof=1)) if len(off) > 1 else math.nan,
        robust_sd=TO_SD * float(np.median(np.abs(off - middle))) if len(off) > 1 else math.nan,
        expected=int(sure.sum()),
        missed=_share(sure & ~right, sure),
        returns=int(returned.sum()),
        false=_share(returned & ~right, returned),
    )


def _share(some: NDArray[np.bool_], of: NDArray[np.bool_]) -> float:
    return float(some.sum() / of.sum()) if of.any() else math.nan
