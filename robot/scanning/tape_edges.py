"""Compiled search for tape in the edge kernel's answers: pairs of edges, straight and wide enough.

One row is one ray. A pair is a place where it gets darker (entry) and the next place where it gets
brighter (exit). A pair counts if the entries on neighbouring rays lie on a line and the distance
between entry and exit, measured across that line, is the tape's width.
"""

from __future__ import annotations

import math
from enum import IntEnum

import numpy as np
from numba import njit
from numpy.typing import NDArray

from robot.geometry import Array

PAIRS = 4
"""Pairs kept on one ray; farther ones are left out."""

NEIGHBOURS = 48
"""Rays to either side that may support a pair."""


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
_NO_EDGE = int(Verdict.NO_EDGE)
_TOO_SHORT = int(Verdict.TOO_SHORT)
_NOT_STRAIGHT = int(Verdict.NOT_STRAIGHT)
_WRONG_WIDTH = int(Verdict.WRONG_WIDTH)


@njit(cache=True, nogil=True)
def find_pairs(
    response: NDArray[np.float32], counts: NDArray[np.int32], threshold: float, border: int
) -> tuple[Array, NDArray[np.int32]]:
    """Entry and exit of dark stripes on each ray, in samples with fractions.

    Args:
        response: (k, m) edge kernel's answer in grey levels, negative where it gets darker.
        counts: (k,) samples in use on each ray.
        threshold: weakest edge that is one [grey levels].
        border: samples at each end of a ray where the kernel looks past it.

    Returns:
        Pairs (k, PAIRS, 2), nan where there is none, and how many edges were met, (k,): an odd
        number means that the last entry has no exit.
    """
    rays = response.shape[0]
    pairs = np.full((rays, PAIRS, 2), np.nan)
    edges = np.zeros(rays, dtype=np.int32)
    for ray in range(rays):
        found = 0
        entry = -1
        for i in range(border, counts[ray] - border):
            if _is_peak(response[ray], i, -threshold) and (
                entry < 0 or response[ray, i] < response[ray, entry]
            ):
                if entry < 0:
                    edges[ray] += 1
                entry = i
            elif entry >= 0 and _is_peak(-response[ray], i, -threshold):
                edges[ray] += 1
                pairs[ray, found, 0] = _refine(response[ray], entry)
                pairs[ray, found, 1] = _refine(response[ray], i)
                found += 1
                entry = -1
                if found == PAIRS:
                    break
    return pairs, edges


@njit(cache=True, nogil=True, inline="always")
def _is_peak(row: NDArray[np.float32], i: int, below: float) -> bool:
    return bool(row[i] <= below and row[i] <= row[i - 1] and row[i] < row[i + 1])


@njit(cache=True, nogil=True)
def _refine(row: NDArray[np.float32], i: int) -> float:
    """Top of the parabola through a peak and its two neighbours."""
    before, at, after = row[i - 1], row[i], row[i + 1]
    bend = before - 2 * at + after
    if bend == 0:
        return float(i)
    return i + 0.5 * float(before - after) / float(bend)


@njit(cache=True, nogil=True)
def judge_pairs(
    entries: Array,
    exits: Array,
    width: float,
    width_tolerance: float,
    support: float,
    straightness: float,
) -> tuple[NDArray[np.int8], NDArray[np.int8], Array, Array]:
    """Which pairs are tape.

    Args:
        entries: (k, PAIRS, 2) points [m] where rays enter; nan where there is no pair.
        exits: (k, PAIRS, 2) points [m] where they leave.
        width: the tape's width [m].
        width_tolerance: how far the measured width may be off [m].
        support: length of edge [m] that must be seen on neighbouring rays.
        straightness: how far entries may lie off their common line [m].

    Returns:
        For each ray the nearest pair that counts, or the one that came closest to counting:
        its index (k,), the ``Verdict`` (k,), its measured width (k,) [m] and the unit normal of
        its entry edge (k, 2), toward the rays' side; nan where no line was found.
    """
    rays = entries.shape[0]
    chosen = np.zeros(rays, dtype=np.int8)
    verdicts = np.full(rays, _NO_EDGE, dtype=np.int8)
    widths = np.full(rays, np.nan)
    normals = np.full((rays, 2), np.nan)
    line = np.empty(3)
    for ray in range(rays):
        for pair in range(PAIRS):
            if np.isnan(entries[ray, pair, 0]):
                break
            verdict = _fit_edge(entries, ray, pair, support, straightness, line)
            across = np.nan
            if verdict == _COUNTED:
                across = abs(
                    line[0] * (exits[ray, pair, 0] - entries[ray, pair, 0])
                    + line[1] * (exits[ray, pair, 1] - entries[ray, pair, 1])
                )
                if abs(across - width) > width_tolerance:
                    verdict = _WRONG_WIDTH
            if pair == 0 or verdict == _COUNTED or verdict > verdicts[ray]:
                chosen[ray], verdicts[ray], widths[ray] = pair, verdict, across
                normals[ray, 0], normals[ray, 1] = line[0], line[1]
            if verdict == _COUNTED:
                break
    return chosen, verdicts, widths, normals


@njit(cache=True, nogil=True)
def _fit_edge(
    entries: Array, ray: int, pair: int, support: float, straightness: float, line: Array
) -> int:
    """The line through a pair's entry and its neighbours, to both sides or to one.

    Puts the unit normal and the worst distance into ``line`` (3,): nan and inf without a line.
    """
    points = np.empty((2 * NEIGHBOURS + 1, 2))
    middle = NEIGHBOURS
    points[middle] = entries[ray, pair]
    left = _collect(entries, ray, pair, -1, support, points, middle)
    right = _collect(entries, ray, pair, 1, support, points, middle)
    verdict = _TOO_SHORT
    line[:] = np.nan, np.nan, np.inf
    trial = np.empty(3)
    # Both halves first: it is the best fit; beside a corner or an end one side alone is straight.
    for first, last in (
        (middle - left // 2, middle + right // 2),
        (middle - left, middle),
        (middle, middle + right),
    ):
        if last - first < 2 or _distance(points[first], points[last]) < 0.9 * support:
            continue
        _fit_line(points, first, last, trial)
        if trial[2] < line[2]:
            line[:] = trial
    if np.isfinite(line[2]):
        straight = line[2] <= straightness
        verdict = _COUNTED if straight else _NOT_STRAIGHT
    return verdict


@njit(cache=True, nogil=True)
def _collect(
    entries: Array,
    ray: int,
    pair: int,
    step: int,
    support: float,
    points: Array,
    middle: int,
) -> int:
    """Walk to one side along neighbouring entries until their chord is long enough."""
    count = 0
    at = entries[ray, pair]
    other = ray + step
    while 0 <= other < entries.shape[0] and count < NEIGHBOURS:
        best, gap = -1, support
        for candidate in range(PAIRS):
            if np.isnan(entries[other, candidate, 0]):
                break
            away = _distance(entries[other, candidate], at)
            if away < gap:
                best, gap = candidate, away
        if best < 0:
            break
        at = entries[other, best]
        count += 1
        points[middle + step * count] = at
        if _distance(at, points[middle]) >= support:
            break
        other += step
    return count


@njit(cache=True, nogil=True)
def _fit_line(points: Array, first: int, last: int, line: Array) -> None:
    """Total least squares through points first..last: unit normal and worst distance."""
    count = last - first + 1
    mean_x = points[first : last + 1, 0].sum() / count
    mean_y = points[first : last + 1, 1].sum() / count
    xx = xy = yy = 0.0
    for i in range(first, last + 1):
        dx, dy = points[i, 0] - mean_x, points[i, 1] - mean_y
        xx += dx * dx
        xy += dx * dy
        yy += dy * dy
    along = 0.5 * math.atan2(2 * xy, xx - yy)
    nx, ny = -math.sin(along), math.cos(along)
    if nx * mean_x + ny * mean_y > 0:
        nx, ny = -nx, -ny
    worst = 0.0
    for i in range(first, last + 1):
        off = abs(nx * (points[i, 0] - mean_x) + ny * (points[i, 1] - mean_y))
        worst = max(worst, off)
    line[0], line[1], line[2] = nx, ny, worst


@njit(cache=True, nogil=True, inline="always")
def _distance(a: Array, b: Array) -> float:
    return math.hypot(a[0] - b[0], a[1] - b[1])
