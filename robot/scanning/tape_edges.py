"""Compiled decision which edges are tape's: those that lie on a line, a tape's width apart.

A pair is a place on a ray where it gets darker (entry) and the next where it gets brighter (exit).
It counts if the entries on neighbouring rays lie on a line and the distance between entry and exit,
measured across that line, is the tape's width and stays so.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array

NEIGHBOURS = 48
"""Rays to either side that may support a pair."""

GAP = 2.0
"""Neighbouring entries of one edge lie at most so many times the support apart."""

SIDE = 4
"""Neighbours to each side that are asked, however far away they lie."""


class Verdict(IntEnum):
    """Why a ray counted, or did not."""

    COUNTED = 0
    OUT_OF_SIGHT = 1
    NO_EDGE = 2
    NO_EXIT = 3
    TOO_SHORT = 4
    NOT_STRAIGHT = 5
    WRONG_WIDTH = 6


# Compiled code knows plain numbers only.
_COUNTED = int(Verdict.COUNTED)
_OUT_OF_SIGHT = int(Verdict.OUT_OF_SIGHT)
_NO_EDGE = int(Verdict.NO_EDGE)
_NO_EXIT = int(Verdict.NO_EXIT)
_TOO_SHORT = int(Verdict.TOO_SHORT)
_NOT_STRAIGHT = int(Verdict.NOT_STRAIGHT)
_WRONG_WIDTH = int(Verdict.WRONG_WIDTH)


@njit(cache=True, nogil=True)
def judge_pairs(
    pairs: Array,
    met: NDArray[np.int32],
    width: float,
    width_tolerance: float,
    support: float,
    straightness: float,
    taper: float,
) -> tuple[NDArray[np.int8], NDArray[np.int8], Array, Array]:
    """Which pairs are tape.

    Args:
        pairs: (k, p, 4) x and y [m] of entry and exit; nan after a ray's last pair.
        met: (k,) edges that each ray met, two a pair; -1 if it is out of sight.
        width: the tape's width [m].
        width_tolerance: how far the measured width may be off [m].
        support: length of edge [m] that must be seen on neighbouring rays.
        straightness: how far entries may lie off their common line [m].
        taper: how much the width may change along that line [m].

    Returns:
        For each ray the nearest pair that counts, or the one that came closest to counting:
        its index (k,), the ``Verdict`` (k,), its width (k,) [m] and the line of its entry edge
        (k, 3): unit normal toward the rays' side, and n . p where the ray meets it; else nan.
    """
    rays = len(pairs)
    chosen = np.zeros(rays, dtype=np.int8)
    verdicts = np.full(rays, _NO_EDGE, dtype=np.int8)
    widths = np.full(rays, np.nan)
    lines = np.full((rays, 3), np.nan)
    chain = np.empty((2 * NEIGHBOURS + 1, 4))
    line = np.empty(5)
    for ray in range(rays):
        if met[ray] < 0:
            verdicts[ray] = _OUT_OF_SIGHT
        elif met[ray] == 1:
            verdicts[ray] = _NO_EXIT
        for pair in range(met[ray] // 2):
            verdict = _fit_edge(pairs, ray, pair, support, straightness, taper, chain, line)
            across = _width(chain, NEIGHBOURS, line) if verdict == _COUNTED else np.nan
            if abs(across - width) > width_tolerance:
                verdict = _WRONG_WIDTH
            if pair == 0 or verdict == _COUNTED or verdict > verdicts[ray]:
                chosen[ray], verdicts[ray], widths[ray] = pair, verdict, across
                lines[ray, 0], lines[ray, 1], lines[ray, 2] = line[0], line[1], line[2]
            if verdict == _COUNTED:
                break
    sure = verdicts == _COUNTED
    for step in (1, -1):
        _go_on(pairs, step, support, straightness, chosen, verdicts, widths, lines, sure)
    return chosen, verdicts, widths, lines


@njit(cache=True, nogil=True)
def _go_on(
    pairs: Array,
    step: int,
    support: float,
    straightness: float,
    chosen: NDArray[np.int8],
    verdicts: NDArray[np.int8],
    widths: Array,
    lines: Array,
    sure: NDArray[np.bool_],
) -> None:
    """Count rays whose entry goes on the line of the ray beside them, though their exit does not.

    So it is by corners, where rays leave through another tape, and where they all but run along an
    edge. It goes on by as many rays at most as are sure of it.
    """
    rays, most, _ = pairs.shape
    strength = 0
    for i in range(rays):
        ray = i if step > 0 else rays - 1 - i
        if sure[ray]:
            strength += 1
            continue
        beside, strength = ray - step, strength - 1
        if strength < 0 or verdicts[beside] != _COUNTED:
            strength = 0
            continue
        last, line = pairs[beside, chosen[beside]], lines[beside]
        for pair in range(most):
            x, y = pairs[ray, pair, 0], pairs[ray, pair, 1]
            near = _squared(pairs[ray, pair], last) <= (GAP * support) ** 2
            if near and abs(line[0] * x + line[1] * y - line[2]) <= straightness:
                chosen[ray], verdicts[ray] = pair, _COUNTED
                lines[ray], widths[ray] = lines[beside], widths[beside]
                break


@njit(cache=True, nogil=True)
def _fit_edge(
    pairs: Array,
    ray: int,
    pair: int,
    support: float,
    straightness: float,
    taper: float,
    chain: Array,
    line: Array,
) -> int:
    """The line through a pair's entry and its neighbours, to both sides or to one.

    Puts it into ``line`` as ``_fit_line`` does: nan and inf without one.
    """
    middle = NEIGHBOURS
    left = _collect(pairs, ray, pair, -1, support, chain)
    right = _collect(pairs, ray, pair, 1, support, chain)
    line[:] = np.nan
    line[3] = np.inf
    trial = np.empty(5)
    # Both halves first: it is the best fit; beside a corner or an end one side alone is straight.
    for first, last in (
        (middle - left, middle + right),
        (middle - left // 2, middle + right // 2),
        (middle - left, middle),
        (middle, middle + right),
    ):
        if last - first < 2 or _squared(chain[first], chain[last]) < (0.9 * support) ** 2:
            continue
        _fit_line(chain, first, last, trial)
        straight = trial[3] <= straightness and _taper(chain, first, last, trial) <= taper
        if straight or trial[3] < line[3]:
            line[:] = trial
        if straight:
            line[2] += _bow(chain, first, last, line)
            return _COUNTED
    return _TOO_SHORT if np.isinf(line[3]) else _NOT_STRAIGHT


@njit(cache=True, nogil=True)
def _collect(pairs: Array, ray: int, pair: int, step: int, support: float, chain: Array) -> int:
    """Walk to one side along neighbouring entries until they are enough; returns how many."""
    rays, most, _ = pairs.shape
    at = NEIGHBOURS
    for j in range(4):
        chain[at, j] = pairs[ray, pair, j]
    for count in range(1, NEIGHBOURS + 1):
        other = ray + step * count
        if not 0 <= other < rays:
            return count - 1
        best, gap = -1, (GAP * support) ** 2
        for candidate in range(most):
            away = _squared(pairs[other, candidate], chain[at])
            # Never true of nan, where there is no pair.
            if away < gap:
                best, gap = candidate, away
        if best < 0:
            return count - 1
        at += step
        for j in range(4):
            chain[at, j] = pairs[other, best, j]
        if count >= SIDE and _squared(chain[at], chain[NEIGHBOURS]) >= support * support:
            return count
    return NEIGHBOURS


@njit(cache=True, nogil=True)
def _fit_line(chain: Array, first: int, last: int, line: Array) -> None:
    """Total least squares through the entries first..last of a chain.

    Puts unit normal (2), n . p, the worst distance and the mean place along it into ``line`` (5,).
    """
    count = last - first + 1
    mean_x = mean_y = xx = xy = yy = 0.0
    for i in range(first, last + 1):
        mean_x += chain[i, 0] / count
        mean_y += chain[i, 1] / count
    for i in range(first, last + 1):
        dx, dy = chain[i, 0] - mean_x, chain[i, 1] - mean_y
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
    along = 0.5 * math.atan2(2 * xy, xx - yy)
    nx, ny = -math.sin(along), math.cos(along)
    if nx * mean_x + ny * mean_y > 0:
        nx, ny = -nx, -ny
    offset = nx * mean_x + ny * mean_y
    worst = 0.0
    for i in range(first, last + 1):
        worst = max(worst, abs(nx * chain[i, 0] + ny * chain[i, 1] - offset))
    line[0], line[1], line[2], line[3] = nx, ny, offset, worst
    line[4] = ny * mean_x - nx * mean_y


@njit(cache=True, nogil=True)
def _taper(chain: Array, first: int, last: int, line: Array) -> float:
    """How much the width grows or shrinks from end to end of an edge, by its trend [m]."""
    squares = product = 0.0
    for i in range(first, last + 1):
        t = _place(chain, i, line)
        squares += t * t
        product += t * _width(chain, i, line)
    return abs(product / squares) * math.sqrt(_squared(chain[first], chain[last]))


@njit(cache=True, nogil=True)
def _bow(chain: Array, first: int, last: int, line: Array) -> float:
    """How far a curved edge lies off its line at the middle of the chain; 0 if it is straight.

    By the parabola through the entries first..last, if it stands out of their noise.
    """
    count = last - first + 1
    if count < 6:
        return 0.0
    squares = cubes = 0.0
    for i in range(first, last + 1):
        t = _place(chain, i, line)
        squares += t * t
        cubes += t * t * t
    # The square less its own line: what a parabola adds to the line that is there already.
    tilt, level = cubes / squares, squares / count
    product = total = rest = 0.0
    for i in range(first, last + 1):
        t = _place(chain, i, line)
        off = line[0] * chain[i, 0] + line[1] * chain[i, 1] - line[2]
        shape = t * t - tilt * t - level
        product += shape * off
        total += shape * shape
        rest += off * off
    explained = product * product / total
    # Three standard errors.
    if explained < 9 * (rest - explained) / (count - 3):
        return 0.0
    t = _place(chain, NEIGHBOURS, line)
    return float(product / total * (t * t - tilt * t - level))


@njit(cache=True, nogil=True, inline="always")
def _place(chain: Array, i: int, line: Array) -> float:
    """Where along a line an entry lies, from the mean of all [m]."""
    return float(line[1] * chain[i, 0] - line[0] * chain[i, 1] - line[4])


@njit(cache=True, nogil=True, inline="always")
def _width(chain: Array, i: int, line: Array) -> float:
    """Distance from an entry to its exit across a line [m]."""
    across = line[0] * (chain[i, 2] - chain[i, 0]) + line[1] * (chain[i, 3] - chain[i, 1])
    return float(abs(across))


@njit(cache=True, nogil=True, inline="always")
def _squared(a: Array, b: Array) -> float:
    return float((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]))
