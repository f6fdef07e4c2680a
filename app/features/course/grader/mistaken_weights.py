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


def ends(
    poses: Array, bearings: Array, ranges: Array, mistakes: frozenset[str]
) -> tuple[Array, Array]:
    """Return x and y (n, k) where the rays (k,) of guesses (n, 3) end [m]."""
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
    cosine, sine = np.cos(angles), np.sin(angles)
    functions = {
        "sine-first": (sine, cosine), "cosine-twice": (cosine, cosine), "sine-twice": (sine, sine)
    }  # fmt: skip
    x, y = (ranges * each for each in by_mistake(mistakes, functions, (cosine, sine)))
    if mistakes & {"x-mirrored", "ray-backwards"}:
        x = -x
    if mistakes & {"y-mirrored", "ray-backwards"}:
        y = -y
    if "place-lost" in mistakes:
        return x, y
    axes = {"place-x-twice": (0, 0), "place-y-twice": (1, 1), "place-exchanged": (1, 0)}
    across, along = by_mistake(mistakes, axes, (0, 1))
    return poses[:, [across]] + x, poses[:, [along]] + y


def distances(x: Array, y: Array, field: SimpleNamespace, mistakes: frozenset[str]) -> Array:
    """Return how far from the tape places are, by the field's table [m]."""
    start = by_mistake(mistakes, _starts(field.origin), field.origin)
    across = 0.5 if mistakes & {"rounded", "rounded-x"} else 0.0
    along = 0.5 if mistakes & {"rounded", "rounded-y"} else 0.0
    columns = np.floor((x - start[0]) / field.cell + across).astype(int)
    rows = np.floor((y - start[1]) / field.cell + along).astype(int)
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


def _starts(origin: Array) -> dict[str, Array]:
    """Return what is taken for a field's origin, by mistake."""
    x, y = origin
    return {
        "origin-ignored": np.zeros(2),
        "origin-x-ignored": np.array([0.0, y]),
        "origin-y-ignored": np.array([x, 0.0]),
        "origin-added": -origin,
        "origin-x-added": np.array([-x, y]),
        "origin-y-added": np.array([x, -y]),
        "origin-swapped": np.array([y, x]),
        "origin-x-twice": np.array([x, x]),
        "origin-y-twice": np.array([y, y]),
    }


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
