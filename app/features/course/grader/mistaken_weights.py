"""Weights of poses by a field (Table 6.3 of Probabilistic Robotics), with usual mistakes."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from app.features.course.grader.case import by_mistake
from robot.geometry import Array

HIT, RANDOM = 0.95, 0.05
"""Share of rays that end at tape, and of those that end anywhere."""
SIGMA = 0.04
"""Standard deviation of where a ray ends [m]."""
OFF: dict[str, tuple[int, int]] = {
    "row-before": (-1, 0), "row-after": (1, 0), "column-before": (0, -1), "column-after": (0, 1),
    "cell-before": (-1, -1), "cell-after": (1, 1),
}  # fmt: skip
"""Rows and columns by which a cell is missed."""
NARROW = {
    "half-left-out": 0.5**0.5, "half": 0.5, "tenth": 0.1, "hundredth": 0.01, "mm": 0.001,
    "fourth-power": SIGMA, "third-power": SIGMA**0.5,
}  # fmt: skip
WIDE = {"first-power": SIGMA**-0.5, "twice": 2.0, "multiplied": SIGMA**-2}
WIDTHS = NARROW | WIDE
"""How wide the bell curve becomes, in sigmas."""
INVERSES: dict[str, Callable[[Array], Array]] = {
    "inverse-sum": lambda away: 1 / away.sum(axis=1),
    "inverse-mean": lambda away: 1 / away.mean(axis=1),
    "inverse-squares": lambda away: 1 / (away**2).sum(axis=1),
    "inverse-sum-log": lambda away: -np.log(away.sum(axis=1)),
}

MERGED: dict[str, tuple[Callable[[Array], Array], bool]] = {
    f"{name}-distance{'-of-all' * together}": (rule, together)
    for together in (False, True)
    for name, rule in {
        "mean": lambda away: away.mean(axis=1),
        "summed": lambda away: away.sum(axis=1),
        "median": lambda away: np.median(away, axis=1),
        "root-mean-square": lambda away: np.sqrt((away**2).mean(axis=1)),
    }.items()
}
"""Distances of all rays made one before the curve; whether its logarithm counts for each ray."""


def ends(
    poses: Array, bearings: Array, ranges: Array, mistakes: frozenset[str]
) -> tuple[Array, Array]:
    """Return x and y (n, k) where the rays (k,) of guesses (n, 3) end [m]."""
    x, y = (
        _ends_along(axis, poses, bearings, ranges, _of_axis(name, mistakes))
        for axis, name in enumerate("xy")
    )
    return x, y


def _of_axis(axis: str, mistakes: frozenset[str]) -> frozenset[str]:
    """Return mistakes with those that are made of one coordinate alone, x or y."""
    own = (name.removesuffix(f"-{axis}") for name in mistakes if name.endswith(f"-{axis}"))
    return mistakes.union(own)


def _ends_along(
    axis: int, poses: Array, bearings: Array, ranges: Array, mistakes: frozenset[str]
) -> Array:
    headings = poses[:, 2:] * ("no-heading" not in mistakes)
    if "heading-as-degrees" in mistakes:
        headings = np.radians(headings)
    if "bearings-as-degrees" in mistakes:
        bearings = np.radians(bearings)
    if "no-bearing" in mistakes:
        bearings = 0 * bearings
    angles = headings - bearings if "bearing-subtracted" in mistakes else headings + bearings
    if "heading-subtracted" in mistakes:
        angles = bearings - headings
    if "angles-as-degrees" in mistakes:
        angles = np.radians(angles)
    sine = (axis == 1) != ("sine-first" in mistakes)
    ray: Array = ranges * (np.sin(angles) if sine else np.cos(angles))
    if "ray-backwards" in mistakes:
        ray = -ray
    if "place-lost" in mistakes:
        return ray
    place = 1 - axis if "place-exchanged" in mistakes else axis
    return poses[:, [place]] + ray


def distances(x: Array, y: Array, field: SimpleNamespace, mistakes: frozenset[str]) -> Array:
    """Return how far from the tape places are, by the field's table [m]."""
    columns, rows = (
        _cells_along(axis, along, field, _of_axis(name, mistakes))
        for axis, (name, along) in enumerate((("x", x), ("y", y)))
    )
    if "rows" in mistakes:
        rows, columns = columns, rows
    row_off, column_off = by_mistake(mistakes, OFF, (0, 0))
    rows, columns = rows + row_off, columns + column_off
    height, width = field.distances.shape
    rows = -rows if "row-negative" in mistakes else rows
    rows = height - 1 - rows if "upside-down" in mistakes else rows
    columns = width - 1 - columns if "mirrored" in mistakes else columns
    if "unclipped" in mistakes:  # what Python finds beyond one side is at the other one
        beyond: Array = field.distances[rows % height, columns % width]
        return beyond
    result: Array = field.distances[rows.clip(0, height - 1), columns.clip(0, width - 1)]
    return result


def _cells_along(
    axis: int, along: Array, field: SimpleNamespace, mistakes: frozenset[str]
) -> NDArray[np.int_]:
    start = field.origin[axis]
    starts = {
        "origin-ignored": 0.0, "origin-added": -start, "origin-swapped": field.origin[1 - axis],
        "origin-undivided": start * field.cell,
    }  # fmt: skip
    apart = (along - by_mistake(mistakes, starts, start)) / field.cell
    cells: NDArray[np.int_] = np.floor(apart + 0.5 * ("rounded" in mistakes)).astype(int)
    return cells


def within(x: Array, y: Array, field: SimpleNamespace) -> NDArray[np.bool_]:
    """Return whether places are on the field's table."""
    height, width = field.distances.shape
    columns = np.floor((x - field.origin[0]) / field.cell)
    rows = np.floor((y - field.origin[1]) / field.cell)
    result: NDArray[np.bool_] = (columns >= 0) & (columns < width) & (rows >= 0) & (rows < height)
    return result


def weights_of(away: Array, sigma: float, mistakes: frozenset[str]) -> Array:
    """Return the log-weights (n,) of guesses whose rays end away (n, k) from the tape [m]."""
    inverse = next((rule for name, rule in INVERSES.items() if name in mistakes), None)
    if inverse is not None:
        result: Array = inverse(away)
        return result
    merged = by_mistake(mistakes, MERGED, None)
    if merged is not None:
        made, together = merged
        rays = away.shape[1] if together else 1
        return rays * weights_of(made(away)[:, None], sigma, frozenset())
    width = sigma * next((value for name, value in WIDTHS.items() if name in mistakes), 1.0)
    sign = 1.0 if "sign" in mistakes else -1.0
    square = away if "no-square" in mistakes else away**2
    if "nothing-squared" in mistakes:
        fit = np.exp(-away / (2 * width))
    else:
        fit = np.exp(sign * square / (2 * width**2))
    fit = away if "no-curve" in mistakes else fit
    if "outliers-inside" in mistakes:
        fit = fit * math.exp(RANDOM) - RANDOM / HIT
    likelihood = fit if "no-outliers" in mistakes or "product" in mistakes else HIT * fit + RANDOM
    if "normal-density" in mistakes:
        likelihood = HIT * fit / math.sqrt(2 * math.pi * width**2) + RANDOM
    if "only-hits" in mistakes:
        return _joined(HIT * fit, mistakes)
    if "no-outliers" in mistakes:
        total: Array = sign * (square / (2 * width**2)).sum(axis=1)
        return total
    return _joined(likelihood, mistakes)


def _joined(likelihood: Array, mistakes: frozenset[str]) -> Array:
    rule = next((rule for name, rule in JOINED.items() if name in mistakes), None)
    return rule(likelihood) if rule else _log_sum(likelihood)


def _log_sum(likelihood: Array) -> Array:
    result: Array = np.log(likelihood).sum(axis=1)
    return result


def _shared(likelihood: Array) -> Array:
    weights = _log_sum(likelihood)
    shares = np.exp(weights - weights.max())
    result: Array = shares / shares.sum()
    return result


def _extreme(likelihood: Array, largest: bool) -> Array:
    logarithms = np.log(likelihood)
    result: Array = logarithms.max(axis=1) if largest else logarithms.min(axis=1)
    return result


JOINED: dict[str, Callable[[Array], Array]] = {
    "mean": lambda likelihood: _log_sum(likelihood) / likelihood.shape[1],
    "cubed": lambda likelihood: _log_sum(likelihood) / 3,
    "sum": lambda likelihood: np.log(likelihood.sum(axis=1)),
    "plain-sum": lambda likelihood: likelihood.sum(axis=1),
    "plain": lambda likelihood: likelihood.prod(axis=1),
    "plain-product": lambda likelihood: likelihood.prod(axis=1),
    "product": lambda likelihood: np.log(likelihood.prod(axis=1)),
    "negative": lambda likelihood: -_log_sum(likelihood),
    "shares": _shared,
    "log-shares": lambda likelihood: np.log(_shared(likelihood)),
    "from-best": lambda likelihood: _log_sum(likelihood) - _log_sum(likelihood).max(),
    "by-best": lambda likelihood: np.exp(_log_sum(likelihood) - _log_sum(likelihood).max()),
    "largest": lambda likelihood: _extreme(likelihood, largest=True),
    "smallest": lambda likelihood: _extreme(likelihood, largest=False),
    "log-ten": lambda likelihood: _log_sum(likelihood) / math.log(10),
    "log-two": lambda likelihood: _log_sum(likelihood) / math.log(2),
    "first-ray": lambda likelihood: np.log(likelihood[:, 0]),
    "last-ray": lambda likelihood: np.log(likelihood[:, -1]),
    "averaged": lambda likelihood: np.log(likelihood.mean(axis=1)),
    "plain-mean": lambda likelihood: likelihood.mean(axis=1),
    "late-logarithm": lambda likelihood: np.log(likelihood.prod(axis=1)),
}
