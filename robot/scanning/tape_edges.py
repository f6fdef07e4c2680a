"""Compiled decision which edges belong to tape: those on a line or an arc, a tape's width apart.

What half and twice of a constant change is said as ``python -m benchmarks.constants`` found it:
besides, 1.8 % of straight and 2.5 % of bent tape is missed.

A pair is the entry, where a ray meets a stripe, and the next exit, where it leaves it. A pair
counts under two conditions. The entries on neighbouring rays lie on a line, or on an arc that bends
no tighter than tape does. The distance from entry to exit across it is the tape's width along the
whole edge.
"""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array
from robot.scanning.edge_curves import (
    bow,
    distance,
    fit_arc,
    fit_line,
    meet,
    squared,
    taper,
    width,
)

NEIGHBOURS = 48
"""Largest number of rays on either side that may support a pair."""

GAP = 2.0
"""Neighbouring entries of one edge are at most this many times the support apart. Half: 1.9 % of
straight and 2.6 % of bent tape is missed; twice: 1.8 and 2.7 %."""

STRICTER = 2.0
"""The limits of straightness and width are this many times tighter for an arc than for a line.
Half: 2.4 % of bent tape is missed, and no return is false; twice: nothing is gained or lost."""

SIDE = 4
"""This many neighbours on each side are used even if fewer already span the support."""


Limits = tuple[Array, float, float, float, float, float]
"""Widths of tape (n,), width_tolerance, support, straightness, max_taper, bend_radius [m]."""


class Verdict(IntEnum):
    """Why a ray counts or does not count."""

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


@compiled()
def judge_pairs(
    pairs: Array,
    met: NDArray[np.int32],
    tape_widths: Array,
    width_tolerance: float,
    support: float,
    straightness: float,
    max_taper: float,
    bend_radius: float,
) -> tuple[NDArray[np.int8], NDArray[np.int8], Array, Array]:
    """Decide which pairs are tape.

    Args:
        pairs: (k, p, 4) x and y [m] of entry and exit; nan after a ray's last pair.
        met: (k,) number of edges that each ray met, two for each pair; -1 if it is out of sight.
        tape_widths: (n,) of the kinds of tape [m].
        width_tolerance: how far the measured width may be off [m].
        support: length of edge [m] that must be seen on neighbouring rays.
        straightness: how far entries may lie off their common line or arc [m].
        most_taper: how much the width may change along the edge [m].
        bend_radius: radius of the tightest arc that can be an edge of tape [m].

    Returns:
        For each ray, the nearest pair that counts, or else the pair that came closest to counting:
        its index (k,), the ``Verdict`` (k,), its width (k,) [m] and the line of its entry edge
        (k, 3). The line is the unit normal n toward the rays' side, and n . p where the ray meets
        the line; of an arc, it is the tangent there. Without a line it is nan.
    """
    rays = len(pairs)
    chosen = np.zeros(rays, dtype=np.int8)
    verdicts = np.full(rays, _NO_EDGE, dtype=np.int8)
    widths = np.full(rays, np.nan)
    curves = np.full((rays, 6), np.nan)
    limits = (tape_widths, width_tolerance, support, straightness, max_taper, bend_radius)
    chain = np.empty((2 * NEIGHBOURS + 1, 4))
    curve = np.empty(6)
    for ray in range(rays):
        if met[ray] < 0:
            verdicts[ray] = _OUT_OF_SIGHT
        elif met[ray] == 1:
            verdicts[ray] = _NO_EXIT
        for pair in range(met[ray] // 2):
            left = _collect(pairs, ray, pair, -1, support, chain)
            right = _collect(pairs, ray, pair, 1, support, chain)
            verdict, across = judge_chain(chain, left, right, limits, curve)
            if pair == 0 or verdict == _COUNTED or verdict > verdicts[ray]:
                chosen[ray], verdicts[ray], widths[ray] = pair, verdict, across
                curves[ray] = curve
            if verdict == _COUNTED:
                break
    sure = verdicts == _COUNTED
    for step in (1, -1):
        _go_on(pairs, step, support, straightness, chosen, verdicts, widths, curves, sure)
    lines = np.full((rays, 3), np.nan)
    for ray in range(rays):
        entry = pairs[ray, chosen[ray]]
        if verdicts[ray] == _COUNTED:
            meet(entry[0], entry[1], curves[ray], lines[ray])
        else:
            lines[ray] = curves[ray, :3]
    return chosen, verdicts, widths, lines


@compiled()
def width_error(tape_widths: Array, across: float) -> float:
    """Return how far a width is off the nearest of the widths of tape (n,) [m]; inf without any."""
    error = np.inf
    for i in range(len(tape_widths)):
        error = min(error, abs(across - tape_widths[i]))
    return error


@compiled()
def _go_on(
    pairs: Array,
    step: int,
    support: float,
    straightness: float,
    chosen: NDArray[np.int8],
    verdicts: NDArray[np.int8],
    widths: Array,
    curves: Array,
    sure: NDArray[np.bool_],
) -> None:
    """Count rays whose entry continues the edge of the neighbouring ray, even if their exit fails.

    This happens near corners, where rays leave through another tape, and where rays run almost
    along an edge. The edge continues by at most as many rays as are sure of it.
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
        last, curve = pairs[beside, chosen[beside]], curves[beside]
        for pair in range(most):
            x, y = pairs[ray, pair, 0], pairs[ray, pair, 1]
            near = squared(pairs[ray, pair], last) <= (GAP * support) ** 2
            if near and abs(distance(x, y, curve)) <= straightness:
                chosen[ray], verdicts[ray] = pair, _COUNTED
                widths[ray] = widths[beside]
                curves[ray] = curves[beside]
                break


@compiled()
def judge_chain(
    chain: Array,
    left: int,
    right: int,
    limits: Limits,
    curve: Array,
) -> tuple[int, float]:
    """Return the verdict of the pair in the middle of a chain, and its width [m].

    The line or arc of its entry edge is written to ``curve``; without one, that is nan, and inf for
    the worst distance. A line is tried on the entries of both sides, then of one side. An arc is
    tried only where no line makes the pair tape.

    Args:
        chain: (2 * NEIGHBOURS + 1, 4) pairs along an edge, the middle one at NEIGHBOURS.
        left: number of pairs before the middle.
        right: number of pairs after the middle.
        limits: as in ``judge_pairs``: tape_widths, width_tolerance, support, straightness,
            most_taper, bend_radius [m].
        curve: (6,) the output.
    """
    tape_widths, width_tolerance, support, straightness, max_taper, _ = limits
    middle = NEIGHBOURS
    verdict, across = _TOO_SHORT, np.nan
    curve[:] = np.nan
    curve[3] = np.inf
    trial = np.empty(6)
    # Both sides come first, as the best fit; near a corner or an end, only one side is straight.
    spans = (
        (middle - left, middle + right),
        (middle - left // 2, middle + right // 2),
        (middle - left, middle),
        (middle, middle + right),
    )
    for first, last in spans:
        if last - first < 2 or squared(chain[first], chain[last]) < (0.9 * support) ** 2:
            continue
        fit_line(chain, first, last, trial)
        straight = trial[3] <= straightness and taper(chain, first, last, trial) <= max_taper
        if straight or trial[3] < curve[3]:
            curve[:] = trial
            verdict = _NOT_STRAIGHT
        if straight:
            curve[2] += bow(chain, first, last, curve, middle)
            across = width(chain, middle, curve)
            if width_error(tape_widths, across) <= width_tolerance:
                return _COUNTED, across
            verdict = _WRONG_WIDTH
            break
    for first, last in spans:
        if last - first < 2 or squared(chain[first], chain[last]) < (0.9 * support) ** 2:
            continue
        bent = _fit_bend(chain, first, last, limits, trial)
        if bent > 0:
            curve[:] = trial
            return _COUNTED, bent
    return verdict, across


@compiled()
def _fit_bend(
    chain: Array,
    first: int,
    last: int,
    limits: Limits,
    curve: Array,
) -> float:
    """Return the width [m] of tape whose entries lie on an arc; -1 if it is not such tape.

    An arc fits more shapes than a line does, so its limits are ``STRICTER`` times tighter:
    otherwise cables and shoes would pass.
    """
    tape_widths, width_tolerance, _, straightness, max_taper, bend_radius = limits
    fit_line(chain, first, last, curve)
    fit_arc(chain, first, last, curve)
    # Comparisons with nan are false, so nan is rejected here.
    if not (curve[3] <= straightness / STRICTER and abs(curve[5]) * bend_radius <= 1):
        return -1.0
    across = width(chain, NEIGHBOURS, curve)
    if not width_error(tape_widths, across) <= width_tolerance / STRICTER:
        return -1.0
    return across if taper(chain, first, last, curve) <= max_taper else -1.0


@compiled()
def _collect(pairs: Array, ray: int, pair: int, step: int, support: float, chain: Array) -> int:
    """Collect neighbouring entries on one side until they span the support; return how many."""
    rays, most, _ = pairs.shape
    position = NEIGHBOURS
    for j in range(4):
        chain[position, j] = pairs[ray, pair, j]
    for count in range(1, NEIGHBOURS + 1):
        other = ray + step * count
        if not 0 <= other < rays:
            return count - 1
        best, gap = -1, (GAP * support) ** 2
        for candidate in range(most):
            away = squared(pairs[other, candidate], chain[position])
            # False for nan, where there is no pair.
            if away < gap:
                best, gap = candidate, away
        if best < 0:
            return count - 1
        position += step
        for j in range(4):
            chain[position, j] = pairs[other, best, j]
        if count >= SIDE and squared(chain[position], chain[NEIGHBOURS]) >= support * support:
            return count
    return NEIGHBOURS
