"""Lines and arcs through the points of a curve that was flattened, as an editor shows them."""

from __future__ import annotations

import math

import numpy as np

from robot.geometry import Array

TOLERANCE = 0.3
"""Farthest that a line or an arc is from what it stands for [mm]; a line of tape that is laid by
hand is off by more. Of the tape of *town* it makes 68 pieces, half of it 81, and twice 59."""
LARGEST_BEND = math.tan(math.radians(170) / 4)
"""Of one arc: longer ones are made of several, so that each has a middle to pull at."""
Node = tuple[float, float, float]
"""x, y, and the bend of the way to the next node: the tangent of a quarter of its angle, positive
if it turns left; 0 is straight."""


def fitted(points: Array, *, closed: bool, tolerance: float = TOLERANCE) -> list[Node]:
    """Return nodes whose lines and arcs are within a tolerance of a chain of straight lines.

    Args:
        points: (n, 2) [mm], y up; a closed chain does not repeat its first point.
        closed: whether the last point is joined to the first.
        tolerance: [mm].
    """
    kept = points[np.append(True, np.hypot(*np.diff(points, axis=0).T) > 1e-9)]
    if closed and len(kept) > 1 and np.hypot(*(kept[-1] - kept[0])) <= 1e-9:
        kept = kept[:-1]
    if len(kept) < 2:
        return [(float(x), float(y), 0.0) for x, y in kept]
    if closed:
        # It begins where its longest line ends: not in the middle of an arc.
        longest = int(np.hypot(*(np.roll(kept, -1, axis=0) - kept).T).argmax())
        kept = np.roll(kept, -(longest + 1), axis=0)
        kept = np.vstack([kept, kept[:1]])
    nodes, begin, last = [], 0, len(kept) - 1
    while begin < last:
        end, bend = _longest(kept, begin, tolerance)
        nodes.append((float(kept[begin, 0]), float(kept[begin, 1]), bend))
        begin = end
    if not closed:
        nodes.append((float(kept[-1, 0]), float(kept[-1, 1]), 0.0))
    return nodes


def _longest(points: Array, begin: int, tolerance: float) -> tuple[int, float]:
    """Return where the longest line or arc ends that begins at a point, and its bend."""
    last = len(points) - 1
    good, bend, step = begin + 1, 0.0, 1
    # Twice as far as long as it fits, then half of that and so on.
    while step:
        end = min(good + step, last)
        bent = None if end == good else _bend(points[begin : end + 1], tolerance)
        if bent is not None:
            good, bend = end, bent
            step *= 2
        else:
            step //= 2
    return good, bend


def _bend(points: Array, tolerance: float) -> float | None:
    """Return the bend of one line or arc along points (n, 2), n > 2; None if none fits."""
    chord = points[-1] - points[0]
    length = math.hypot(*chord)
    if length < 1e-9:
        return None
    along, left = chord / length, np.array([-chord[1], chord[0]]) / length
    middles = (points[1:] + points[:-1]) / 2
    relative = np.vstack([points, middles]) - points[0]
    ahead, beside = relative @ along, relative @ left
    if abs(beside).max() <= tolerance:
        straight = ahead[: len(points)]
        return 0.0 if (np.diff(straight) > -tolerance).all() else None
    middle = len(points) // 2
    x, y = ahead[middle], beside[middle]
    if abs(y) < 1e-9:
        return None
    # The circle through both ends and the middle point: its centre is (length / 2, height).
    height = (x * x - x * length + y * y) / (2 * y)
    radius = math.hypot(length / 2, height)
    residuals = np.abs(np.hypot(ahead - length / 2, beside - height) - radius)
    sagitta = height + math.copysign(radius, y)
    bend = -2 * sagitta / length
    same_side = (np.sign(y) * beside > -tolerance).all() or abs(bend) > 1
    if residuals.max() > tolerance or abs(bend) > LARGEST_BEND or not same_side:
        return None
    return float(bend)
