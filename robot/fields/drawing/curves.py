"""Flattens curves to chains of straight lines, fine enough for the stroke drawn along them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot.geometry import Array

MAX_LINES = 20_000

_DENSE = 192
"""Number of steps in which the bend of a curve is sampled before the curve is cut."""

_REFINEMENTS = 16
_LOOKED_AT = (0.2, 0.5, 0.8)
"""Positions along each line where its distance from the curve is checked."""

_STRAIGHT = 1e-6
"""A curve that needs fewer lines than this is a straight line."""

_NEAR_END = np.array([1 / 81, 1 / 27, 1 / 9, 1 / 3])
"""Additional points at both ends of a curve, in shares of its first line.

Caps and corners must be square to the curve's end, not to its last chord. Lines must get shorter
step by step; otherwise the wide end of a long line sticks out beyond a cap.
"""


def flatten(curve: Callable[[Array], Array], half_width: float, tolerance: float) -> Array:
    """Return points (n, 2) on a curve, first to last, to be joined by straight lines.

    The curve gives points (n, 2) for parameters (n,) from 0 to 1. A line and its two parallels at
    the half width stay within the tolerance of the curve and of its parallels (same unit).

    Let a chord of length c turn by phi, and h be the half width. The chord is off its arc of radius
    c/phi by phi c / 8 (the sagitta), and its outer parallel by phi (c + h phi) / 8. So a step of
    the dense sampling needs sqrt(phi (c + h phi) / (8 tolerance)) lines. The lines are spread in
    that proportion.

    Raises:
        ValueError: the curve needs absurdly many lines.
    """
    parameters = np.linspace(0, 1, _DENSE + 1)
    chords = np.diff(curve(parameters), axis=0)
    length = np.hypot(chords[:, 0], chords[:, 1])
    turn = _turning(chords)
    asked = np.sqrt(turn * (length + half_width * turn) / (8 * tolerance))
    reached = np.concatenate([[0.0], np.cumsum(asked)])
    total = reached[-1]
    if not total <= MAX_LINES:
        raise ValueError(f"a curve needs more than {MAX_LINES} lines")
    if total < _STRAIGHT:
        return curve(np.array([0.0, 1.0]))
    lines = int(np.ceil(total))
    places = np.linspace(0, total, lines + 1)
    ends = _NEAR_END * places[1]
    places = np.concatenate([[0.0], ends, places[1:-1], total - ends[::-1], [total]])
    # Interpolation needs an increasing sequence; where no line is needed, any position will do.
    rising = reached + np.linspace(0, 1e-9 * total, len(reached))
    return _refined(curve, np.interp(places, rising, parameters), tolerance)


def _refined(curve: Callable[[Array], Array], parameters: Array, tolerance: float) -> Array:
    """Return points (n, 2) at parameters (n,), and more where a line is too far from the curve.

    This happens where a curve bends so sharply that the dense sampling has stepped over the bend.
    """
    for _ in range(_REFINEMENTS):
        points = curve(parameters)
        start, step = parameters[:-1], np.diff(parameters)
        offset = [distances(curve(start + k * step), points[:-1], points[1:]) for k in _LOOKED_AT]
        far = np.max(offset, axis=0) > tolerance
        if not far.any():
            break
        middle = start[far] + step[far] / 2
        parameters = np.insert(parameters, np.flatnonzero(far) + 1, middle)
    return curve(parameters)


def distances(points: Array, start: Array, end: Array) -> Array:
    """Return distances (n,) of points (n, 2) from line segments between start and end (n, 2).

    A single segment (2,) is that of all points.
    """
    across = points - start
    along = np.broadcast_to(end - start, across.shape)
    square = (along**2).sum(axis=1)
    share = np.clip((across * along).sum(axis=1) / np.where(square > 0, square, 1), 0, 1)
    offset: Array = across - share[:, None] * along
    return np.hypot(offset[:, 0], offset[:, 1])


def _turning(chords: Array) -> Array:
    """Return how much the curve turns on each chord (n,) [rad]: half of the corner at each end."""
    before, after = chords[:-1], chords[1:]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    corner = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
    shared: Array = np.concatenate([corner[:1], corner, corner[-1:]]) / 2
    return shared[:-1] + shared[1:]
