"""Dashed lines: the pieces of a line that are drawn."""

from __future__ import annotations

import numpy as np

from robot.geometry import Array

MAX_DASHES = 10_000


def dashes(points: Array, closed: bool, pattern: tuple[float, ...], offset: float) -> list[Array]:
    """Return the drawn pieces, each (m, 2), of a line through points (n, 2), by SVG's rules.

    The pattern holds lengths of dash, gap, dash, gap ... in the unit of the points, not all 0. An
    odd number of lengths is taken twice. The line begins at the offset in the pattern. On a closed
    line, dashes that meet at its start are one.

    Raises:
        ValueError: a length is negative, or there would be absurdly many dashes.
    """
    if min(pattern) < 0:
        raise ValueError(f"a dash of length {min(pattern):g}; valid is 0 or more")
    around = np.vstack([points, points[:1]]) if closed else points
    step = np.diff(around, axis=0)
    walked = np.concatenate([[0.0], np.cumsum(np.hypot(step[:, 0], step[:, 1]))])
    intervals = _intervals(walked[-1], pattern, offset)
    pieces = [_piece(around, walked, start, end) for start, end in intervals]
    if closed and len(pieces) > 1 and intervals[0][0] == 0 and intervals[-1][1] == walked[-1]:
        pieces[0] = np.vstack([pieces.pop(), pieces[0][1:]])
    return pieces


def _intervals(
    length: float, pattern: tuple[float, ...], offset: float
) -> list[tuple[float, float]]:
    """Return where dashes begin and end on a line of this length."""
    even = pattern if len(pattern) % 2 == 0 else pattern * 2
    period = sum(even)
    repeats = int(length / period) + 2
    if repeats * len(even) > 2 * MAX_DASHES:
        raise ValueError(f"more than {MAX_DASHES} dashes; valid are longer ones")
    marks = np.concatenate([[0.0], np.cumsum(even * repeats)]) - offset % period
    starts, ends = np.maximum(marks[:-1:2], 0), np.minimum(marks[1::2], length)
    return [(float(a), float(b)) for a, b in zip(starts, ends, strict=True) if a <= b]


def _piece(around: Array, walked: Array, start: float, end: float) -> Array:
    inside = (walked > start) & (walked < end)
    marks = np.concatenate([[start], walked[inside], [end]])
    return np.column_stack([np.interp(marks, walked, around[:, k]) for k in (0, 1)])
