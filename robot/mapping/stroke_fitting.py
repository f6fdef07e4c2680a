"""Turns traced lines into strokes: straight ones where they are, else splines with few nodes."""

from __future__ import annotations

import numpy as np

from robot.geometry import Array
from robot.mapping.strokes import Stroke

STRAIGHT = 0.003
"""A line is straight if none of its points lies farther off [m]."""
HOOK = 0.04
"""Length at its ends where a line may bend off [m], because corners of tape look round."""
SHORTEST = 0.05
"""A shorter line is no stroke [m]."""
SPACING, FINE_SPACING, DENSEST = 0.08, 0.05, 0.024
"""Distance of the nodes of a spline while the map grows, at the end, and the least one [m]. Where
tape bends more sharply than a spline with fewer nodes can, the path would be bent to fit it."""


def fit_stroke(line: Array, closed: bool = False, spacing: float = SPACING) -> Stroke | None:
    """Return the stroke through points (n, 2) [m] in order; None if they are too short for one.

    Args:
        line: the points [m].
        closed: whether the last one is the first.
        spacing: distance of the nodes, if it is not straight [m].
    """
    if closed:
        return Stroke(_closed_nodes(line, spacing), curved=True, closed=True)
    line = without_hooks(line)
    if len(line) < 3:
        return None
    start, along, aside = straight_fit(line)
    forward = (line - start) @ along
    if np.ptp(forward) < SHORTEST:
        return None
    if np.abs(aside).max() <= STRAIGHT:
        ends = np.array([forward.min(), forward.max()])
        return Stroke(start + ends[:, None] * along)
    return Stroke(_nodes(line, spacing), curved=True)


def straight_fit(line: Array) -> tuple[Array, Array, Array]:
    """Return a point (2,), the direction (2,) of the line through points (n, 2), and how far aside
    of it they lie (n,) [m]."""
    middle = line.mean(axis=0)
    _, _, axes = np.linalg.svd(line - middle, full_matrices=False)
    along = axes[0] * np.sign((line[-1] - line[0]) @ axes[0] or 1.0)
    away = line - middle
    return middle, along, away[:, 1] * along[0] - away[:, 0] * along[1]


def without_hooks(line: Array) -> Array:
    """Return a line without the points at its ends that bend off from the rest."""
    for _ in range(2):
        line = line[::-1]
        walked = _walked(line)
        inner = (walked > HOOK) & (walked < 4 * HOOK)
        if inner.sum() < 3:
            continue
        start, along, aside = straight_fit(line[inner])
        bent = np.abs(aside).max()
        away = line - start
        distance = np.abs(away[:, 1] * along[0] - away[:, 0] * along[1])
        # What bends anyhow bends at its end too.
        wrong = (walked <= HOOK) & (distance > 0.002 + 4 * bent)
        line = line[np.argmin(wrong) :] if wrong[0] else line
    return line


def _walked(line: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])


def _nodes(line: Array, spacing: float) -> Array:
    """Return the nodes (n, 2) of an open spline."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - as in strokes.py

    walked = _walked(line)
    knots = np.linspace(0.0, walked[-1], max(3, 1 + round(walked[-1] / spacing)))
    shares = CubicSpline(knots, np.eye(len(knots)), bc_type="not-a-knot")(walked)
    return np.asarray(np.linalg.lstsq(shares, line, rcond=None)[0], np.float64)


def _closed_nodes(line: Array, spacing: float) -> Array:
    """Return the nodes (n, 2) of a closed spline through points of which the last is the first."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415 - as in strokes.py

    walked = _walked(line)
    count = max(6, round(walked[-1] / spacing))
    knots = np.linspace(0.0, walked[-1], count + 1)
    shape = np.vstack([np.eye(count), np.eye(count)[:1]])
    shares = CubicSpline(knots, shape, bc_type="periodic")(walked)
    return np.asarray(np.linalg.lstsq(shares, line, rcond=None)[0], np.float64)
