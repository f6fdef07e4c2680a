"""Compiled decision which edges belong to dashed tape: dashes of one line, a tape's width apart.

What half and twice of a constant change is said as ``python -m benchmarks.constants`` found it: of
rays across dashed tape 46.8 % return nothing, many of them between two dashes.

A dash is too short to be an edge by itself, and beside it rays pass through the gaps. So entries
on the dashes around are searched for a line that has as many of them as possible: entries on it,
exits a tape's width behind it. Rays that enter a dash by its end lie off the line and do not count.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from robot.compiling import compiled
from robot.geometry import Array
from robot.scanning.edge_curves import distance, fit_line, squared, taper, width
from robot.scanning.tape_edges import NEIGHBOURS, Verdict

REACH = 2.5
"""Entries on a line are searched within this many lengths of a dash."""
FEWEST = 3
"""Smallest number of entries on a line."""
SHARE = 0.15
"""They must be this share of all entries around: clutter has a line through some of its many. Half:
46.1 % return nothing; twice: 50.4; false returns stay at 0.04 %."""
SPAN = 0.5
"""They must extend over this share of a dash."""
SLACK = 0.35
"""Largest error of a dash's width, as a share of it; ``width_tolerance`` may be less. Half: 47.9 %
return nothing; twice: nothing changes."""
MEAN_SLACK = 0.25
"""Largest error of the mean width on a line, in the same unit."""
LONGER = 1.3
"""An edge that is longer than this many dashes is not dashed."""
CLOSE = 0.25
"""Rays this near to each other, in lengths of a dash, would show a gap."""
BESIDE = 1
"""The ray itself, or one this many rays beside it, must cross its dash from side to side."""
_COUNTED = int(Verdict.COUNTED)


@compiled()
def judge_dashes(
    pairs: Array,
    met: NDArray[np.int32],
    kinds: Array,
    limits: tuple[float, float, float],
    chosen: NDArray[np.int8],
    verdicts: NDArray[np.int8],
    widths: Array,
    lines: Array,
) -> None:
    """Count rays that meet a dash before other tape; the outputs are changed in place.

    Args:
        pairs: (k, p, 4) x and y [m] of entry and exit; nan after a ray's last pair.
        met: (k,) number of edges that each ray met; -1 if it is out of sight.
        kinds: (n, 2) width and length of the dashes of each kind of tape [m].
        limits: width_tolerance, straightness and taper [m], as of tape without gaps.
        chosen: (k,) as ``judge_pairs`` returns it.
        verdicts: (k,) for each ray.
        widths: (k,) for each ray.
        lines: (k, 3) for each ray.
    """
    window = np.empty(((2 * NEIGHBOURS + 1) * pairs.shape[1], 5))
    curve = np.empty(6)
    for ray in range(len(pairs)):
        for pair in range(met[ray] // 2):
            if verdicts[ray] == _COUNTED and pair >= chosen[ray]:
                break
            for kind in range(len(kinds)):
                reach = REACH * kinds[kind, 1]
                count = _collect_around(pairs, ray, pair, reach, window)
                across = _dashes_at(window, count, kinds[kind], limits, curve)
                if across > 0:
                    chosen[ray], verdicts[ray], widths[ray] = pair, _COUNTED, across
                    lines[ray] = curve[:3]
                    break


@compiled()
def _collect_around(pairs: Array, ray: int, pair: int, reach: float, window: Array) -> int:
    """Collect the pairs within a reach [m] of one, which comes first; return how many.

    Each row of the window is a pair's four coordinates and the number of its ray.
    """
    window[0, :4], window[0, 4] = pairs[ray, pair], ray
    count = 1
    for other in range(max(ray - NEIGHBOURS, 0), min(ray + NEIGHBOURS + 1, len(pairs))):
        for candidate in range(pairs.shape[1]):
            # False for nan, where there is no pair.
            near = squared(pairs[other, candidate], window[0]) <= reach * reach
            if near and (other != ray or candidate != pair):
                window[count, :4], window[count, 4] = pairs[other, candidate], other
                count += 1
    return count


@compiled()
def _dashes_at(
    window: Array, count: int, kind: Array, limits: tuple[float, float, float], curve: Array
) -> float:
    """Return the mean width of the dashes on whose line the first entry lies; -1 without a line.

    The line is written to ``curve`` (6,), as ``fit_line`` does it.
    """
    width_tolerance, straightness, max_taper = limits
    slack = min(width_tolerance, SLACK * kind[0])
    chain, best = np.empty((count, 5)), np.empty((count, 5))
    most = 0
    for other in range(1, count):
        if squared(window[other], window[0]) < (SPAN * kind[1] / 2) ** 2:
            continue
        size = _on_line(window, count, other, kind[0], slack, straightness, chain)
        if size > most:
            most = size
            best[:size] = chain[:size]
    if most < max(FEWEST, SHARE * count):
        return -1.0
    fit_line(best, 0, most - 1, curve)
    along = _extent(best, most, curve)
    aside = abs(distance(window[0, 0], window[0, 1], curve))
    if along < SPAN * kind[1] or curve[3] > straightness or aside > straightness / 2:
        return -1.0
    if taper(best, 0, most - 1, curve) > max_taper or _is_longer(best, most, kind[1]):
        return -1.0
    if np.abs(best[:most, 4] - window[0, 4]).min() > BESIDE:
        return -1.0
    mean = 0.0
    for i in range(most):
        mean += width(best, i, curve) / most
    return mean if abs(mean - kind[0]) <= min(width_tolerance, MEAN_SLACK * kind[0]) else -1.0


@compiled()
def _on_line(
    window: Array,
    count: int,
    other: int,
    tape_width: float,
    slack: float,
    straightness: float,
    chain: Array,
) -> int:
    """Collect the pairs on the line through the first entry and another; return how many."""
    dx, dy = window[other, 0] - window[0, 0], window[other, 1] - window[0, 1]
    size = math.hypot(dx, dy)
    nx, ny = -dy / size, dx / size
    collected = 0
    for i in range(count):
        aside = nx * (window[i, 0] - window[0, 0]) + ny * (window[i, 1] - window[0, 1])
        across = nx * (window[i, 2] - window[i, 0]) + ny * (window[i, 3] - window[i, 1])
        if abs(aside) <= straightness and abs(abs(across) - tape_width) <= slack:
            chain[collected] = window[i]
            collected += 1
    return collected


@compiled()
def _is_longer(chain: Array, count: int, dash: float) -> bool:
    """Return whether an edge goes on for longer than a dash, on rays that would show a gap."""
    order = np.argsort(chain[:count, 4])
    first = 0
    for i in range(1, count + 1):
        ended = i == count or chain[order[i], 4] - chain[order[i - 1], 4] > 1
        if not ended:
            continue
        length = math.sqrt(squared(chain[order[first]], chain[order[i - 1]]))
        if length > LONGER * dash and length < CLOSE * dash * (i - 1 - first):
            return True
        first = i
    return False


@compiled()
def _extent(chain: Array, count: int, curve: Array) -> float:
    """Return how far entries extend along a line [m]."""
    first, last = np.inf, -np.inf
    for i in range(count):
        along = curve[1] * chain[i, 0] - curve[0] * chain[i, 1]
        first, last = min(first, along), max(last, along)
    return float(last - first)
