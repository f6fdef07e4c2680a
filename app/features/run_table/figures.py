"""Figures of a run: how far its estimates were from the truth, and how two runs differ."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array

Mask = NDArray[np.bool_]

FAR_M, FAR_RAD = 0.05, math.radians(10)
"""An estimate that is farther from the truth is not right, as ``evaluate`` counts [m, rad]."""
HELD_S = 1.0
"""It has become right if it stays so for this time [s]."""
BLOCK_S = 2.0
"""Errors within such a time go together, and are drawn together [s]. Of 300 pairs of runs of 60 s
whose errors wander with a time of 0.5 s about the same level, the interval of 95 % holds zero in
91 %; half of it: 92 %; twice: 93 %, but then a run takes twice as long until it has an interval."""
FEWEST_BLOCKS = 5
"""Fewer say nothing of how much a run varies: the interval would be one of chance."""
DRAWS = 1000
"""Draws for an interval: another seed moves its ends by 2.2 % of its width; half: by 2.8 %, twice:
by 1.7 %, in twice the time."""


@dataclass(frozen=True, eq=False)
class RunSamples:
    """What is known of n pictures of a run, in order."""

    stamps: Array
    """(n,) [s]"""
    errors: Array
    """(n,) distance of the estimate from the truth [m]; inf without an estimate."""
    turns: Array
    """(n,) difference of the headings [rad]; inf without an estimate."""
    misleading: Array
    """(n,) 1 where it says that it is certain and the truth lies outside its bounds, else 0."""

    def since(self, stamp: float) -> RunSamples:
        """Return the pictures from a stamp [s] on."""
        first = int(np.searchsorted(self.stamps, stamp))
        return self._part(slice(first, None))

    def at(self, stamps: Array) -> RunSamples:
        """Return the pictures at some stamps."""
        return self._part(np.isin(self.stamps, stamps))

    @property
    def right(self) -> Mask:
        """(n,) whether the estimate is right."""
        is_right: Mask = (self.errors <= FAR_M) & (self.turns <= FAR_RAD)
        return is_right

    def _part(self, chosen: slice | Mask) -> RunSamples:
        return RunSamples(
            self.stamps[chosen], self.errors[chosen], self.turns[chosen], self.misleading[chosen]
        )


@dataclass(frozen=True)
class RunFigures:
    """What a run comes to."""

    pictures: int
    seconds: float
    """How long they go on, without the time in which the robot stood [s]."""
    rmse: float | None
    """Root mean square of the distances, where there is an estimate [m]; None without any."""
    median: float | None
    """[m]"""
    worst: float | None
    """[m]"""
    lost: float
    """Share of the pictures at which the estimate is not right, or there is none."""
    misleading: float
    """Share of the pictures at which it says certain and the truth lies outside its bounds."""
    time_to_right: float | None
    """From the first picture until it is right for a second [s]; None if it never is."""


@dataclass(frozen=True)
class RunDifference:
    """How the error of a run differs from another one's."""

    rmse: float
    """Root mean square error of the run less the other one's [m]."""
    low: float | None
    high: float | None
    """Interval that holds the difference in 95 % [m]; None if a run is too short for one."""
    paired: bool
    """Whether both saw the same pictures: then what is hard for both does not widen it."""


def figures_of(samples: RunSamples) -> RunFigures | None:
    """Return what a run comes to; None without a picture."""
    stamps = samples.stamps
    if stamps.size == 0:
        return None
    known, steps = samples.errors[np.isfinite(samples.errors)], np.diff(stamps)
    return RunFigures(
        pictures=stamps.size,
        seconds=float(steps[steps < HELD_S].sum()),
        rmse=float(np.sqrt(np.mean(known**2))) if known.size else None,
        median=float(np.median(known)) if known.size else None,
        worst=float(known.max()) if known.size else None,
        lost=float(np.mean(~samples.right)),
        misleading=float(np.mean(samples.misleading)),
        time_to_right=_time_to_right(stamps, samples.right),
    )


def difference_of(run: RunSamples, other: RunSamples) -> RunDifference | None:
    """Return how the error of a run differs from another one's; None if one has no estimate.

    The interval is the percentiles of a block bootstrap: blocks of ``BLOCK_S`` are drawn with
    replacement, the same ones of both if both saw the same pictures (Kunsch, 1989: The jackknife
    and the bootstrap for general stationary observations).
    """
    common = np.intersect1d(run.stamps, other.stamps)
    paired = 2 * common.size > max(run.stamps.size, other.stamps.size)
    if paired:
        run, other = run.at(common), other.at(common)
    both = [run, other]
    if paired:
        known = np.isfinite(run.errors) & np.isfinite(other.errors)
        both = [each.at(run.stamps[known]) for each in both]
    else:
        both = [each.at(each.stamps[np.isfinite(each.errors)]) for each in both]
    if min(each.stamps.size for each in both) == 0:
        return None
    first = [float(each.stamps[0]) for each in both]
    blocks = [_blocks(each, start) for each, start in zip(both, first, strict=True)]
    mine, theirs = (_rms(each.sum(axis=0)) for each in blocks)
    if min(len(each) for each in blocks) < FEWEST_BLOCKS:
        return RunDifference(float(mine - theirs), None, None, paired)
    rng = np.random.default_rng(0)
    drawn = []
    chosen = None
    for each in blocks:
        if chosen is None or not paired:
            chosen = rng.integers(len(each), size=(DRAWS, len(each)))
        drawn.append(_rms(each[chosen].sum(axis=1)))
    low, high = np.quantile(drawn[0] - drawn[1], (0.025, 0.975))
    return RunDifference(float(mine - theirs), float(low), float(high), paired)


def _blocks(samples: RunSamples, start: float) -> Array:
    """Return (m, 2) sum of squared errors [m^2] and number of pictures of each block with any."""
    number = ((samples.stamps - start) // BLOCK_S).astype(int)
    squares = np.bincount(number, samples.errors**2)
    counts = np.bincount(number).astype(float)
    result: Array = np.column_stack((squares, counts))[counts > 0]
    return result


def _rms(sums: Array) -> Array:
    result: Array = np.sqrt(sums[..., 0] / sums[..., 1])
    return result


def _time_to_right(stamps: Array, right: Mask) -> float | None:
    """Return the time from the first stamp until it is right for ``HELD_S`` [s]."""
    began = None
    for stamp, is_right in zip(stamps.tolist(), right.tolist(), strict=True):
        if not is_right:
            began = None
            continue
        began = stamp if began is None else began
        if stamp - began >= HELD_S:
            return float(began - stamps[0])
    return None
