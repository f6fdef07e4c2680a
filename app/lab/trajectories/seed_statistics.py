"""Statistics over many runs, each with its own seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from robot.geometry import Array

DRAW_BATCH = 2**22
"""Numbers that are drawn at a time."""


@dataclass(frozen=True, slots=True)
class Summary:
    """Mean, median and maximum of values of one unit."""

    mean: float
    median: float
    max: float


def summary(values: ArrayLike) -> Summary:
    """Return mean, median and maximum.

    Raises:
        ValueError: there are no values, or one is not finite.
    """
    checked = _checked(values)
    return Summary(float(checked.mean()), float(np.median(checked)), float(checked.max()))


def bootstrap_interval(
    values: ArrayLike, level: float = 0.95, draws: int = 10_000, seed: int = 0
) -> tuple[float, float]:
    """Return the percentile bootstrap interval of the mean.

    After Efron and Tibshirani (1993), chapter 13.

    Args:
        values: one for each run, independent of each other.
        level: how often the interval should hold the true mean, between 0 and 1.
        draws: how many samples are drawn with replacement.
        seed: of the draws; the same seed gives the same interval.

    Raises:
        ValueError: there are no values, one is not finite, or a parameter is out of range.
    """
    checked = _checked(values)
    if not 0 < level < 1:
        raise ValueError(f"level {level:g}; valid is one between 0 and 1")
    if draws < 1:
        raise ValueError(f"{draws} draws; valid are 1 and more")
    rng = np.random.default_rng(seed)
    means, rows = [], max(DRAW_BATCH // len(checked), 1)
    for start in range(0, draws, rows):
        shape = (min(rows, draws - start), len(checked))
        means.append(checked[rng.integers(len(checked), size=shape)].mean(axis=1))
    low, high = np.quantile(np.concatenate(means), [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)


def _checked(values: ArrayLike) -> Array:
    checked = np.asarray(values, dtype=np.float64).ravel()
    if not len(checked) or not np.isfinite(checked).all():
        raise ValueError("no values, or not all finite; valid are finite numbers, one a run")
    return checked
