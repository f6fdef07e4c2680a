"""How late or early scans are stamped, by how they fit odometry: no map is needed for that.

Two scans half a second apart see the same walls. Where the walls of the first are in the second
follows from how the robot moved in between, and odometry tells that for any delay of the stamps.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from app.features.lab.localize.reading.odometry import OdometryTrack
from robot.geometry import Array, Pose2
from robot.scan import Scan

APART_S = 0.4
"""Time between the two scans of a pair [s]."""
DELAYS = np.arange(-1.5, 1.5001, 0.02)
"""The delays that are tried [s]."""
MOST_PAIRS, FEWEST_PAIRS = 120, 15
MOST_RAYS = 90
FAR_M = 0.5
"""A wall that is farther off than this is another one, or was hidden [m]."""
DRAWS = 200
"""Samples of the pairs from which the standard deviation comes."""
LEAST_S = 0.06
"""Delays below this are not told: a laser takes about that long for a scan [s]."""
CERTAIN = 4.0
"""A delay is believed if it is larger than so many of its standard deviations."""
LEAST_GAIN = 0.1
"""Least share by which scans have to fit better."""


class Delay(NamedTuple):
    """A delay of scans, relative to odometry."""

    seconds: float
    """Scans were made so much later than their stamps say [s]."""
    sd: float
    """[s]"""


def pairs_to_compare(stamps: Sequence[float], track: OdometryTrack) -> list[tuple[int, int]]:
    """Choose pairs of scans between which the robot moved in different ways, by rising stamps."""
    times = np.asarray(stamps)
    later = np.searchsorted(times, times + APART_S)
    firsts = np.flatnonzero(later < len(times))
    firsts = firsts[:: max(len(firsts) // (4 * MOST_PAIRS), 1)]
    weighed = []
    for first in firsts.tolist():
        second = int(later[first])
        if times[second] - times[first] > 2 * APART_S:
            continue
        moves = [
            _between(track, stamps[first] + delay, stamps[second] + delay)
            for delay in (-1.0, -0.5, 0.0, 0.5, 1.0)
        ]
        known = [(move.x, move.y, move.theta) for move in moves if move is not None]
        if len(known) >= 3:
            weighed.append((float(np.ptp(known, axis=0).sum()), first, second))
    chosen = sorted(weighed, reverse=True)[:MOST_PAIRS]
    return sorted((first, second) for weight, first, second in chosen if weight > 0)


def measured_delay(pairs: Iterable[tuple[Scan, Scan]], track: OdometryTrack) -> Delay | None:
    """Return the delay that scans have, with its uncertainty; None if they have or tell none."""
    misfits = np.array([_misfits(first, second, track) for first, second in pairs])
    if len(misfits) < FEWEST_PAIRS:
        return None
    usual = _usual(misfits)
    none = int(np.argmin(np.abs(DELAYS)))
    if not np.isfinite(usual[none]):
        return None
    rng = np.random.default_rng(0)
    draws = rng.integers(len(misfits), size=(DRAWS, len(misfits)))
    delays = [_least(_usual(misfits[draw])) for draw in draws]
    seconds, sd = _least(usual), float(np.std(delays))
    gained = usual[none] - usual.min() >= LEAST_GAIN * usual[none]
    inside = DELAYS[0] < seconds < DELAYS[-1]
    if gained and inside and abs(seconds) >= max(LEAST_S, CERTAIN * sd):
        return Delay(seconds, sd)
    return None


def _usual(misfits: Array) -> Array:
    """Return the mean misfit by delay; inf where too few pairs tell it."""
    known = (~np.isnan(misfits)).sum(axis=0)
    mean = np.nansum(misfits, axis=0) / np.maximum(known, 1)
    return np.where(known >= len(misfits) / 2, mean, np.inf)


def _least(misfit: Array) -> float:
    """Return the delay of the least misfit, between the tried ones by a parabola."""
    index = int(np.argmin(misfit))
    if not 0 < index < len(DELAYS) - 1:
        return float(DELAYS[index])
    low, middle, high = misfit[index - 1 : index + 2]
    bend = low - 2 * middle + high
    share = 0.5 * (low - high) / bend if 0 < bend < np.inf else 0.0
    return float(DELAYS[index] + share * (DELAYS[1] - DELAYS[0]))


def _between(track: OdometryTrack, start: float, end: float) -> Pose2 | None:
    """Return how the robot moved between two stamps; None if it is not known."""
    first, second = track.at(start), track.at(end)
    return None if first is None or second is None else first.inverse() @ second


def _misfits(first: Scan, second: Scan, track: OdometryTrack) -> Array:
    """Return how badly two scans fit each other [m], for each delay; nan where it is not known."""
    moves = [
        _between(track, first.stamp + delay, second.stamp + delay) for delay in DELAYS.tolist()
    ]
    result = np.full(len(DELAYS), np.nan)
    known = [index for index, move in enumerate(moves) if move is not None]
    points = first.points()
    points = points[:: max(len(points) // MOST_RAYS, 1)]
    order = np.argsort(second.bearings)
    bearings, ranges = second.bearings[order], second.ranges[order]
    if not known or not len(points) or len(bearings) < 2:
        return result
    step = 1.5 * float(np.median(np.diff(bearings)))
    for index in known:
        move = moves[index]
        assert move is not None
        seen = (move @ second.robot_from_scan).inverse().apply(points)
        angles = np.arctan2(seen[:, 1], seen[:, 0])
        after = np.clip(np.searchsorted(bearings, angles), 1, len(bearings) - 1)
        nearer = angles - bearings[after - 1] < bearings[after] - angles
        place = after - nearer
        met = np.isfinite(ranges[place]) & (np.abs(bearings[place] - angles) <= step)
        if np.count_nonzero(met) >= 5:
            misfit = np.abs(ranges[place][met] - np.hypot(*seen[met].T))
            result[index] = float(np.minimum(misfit, FAR_M).mean())
    return result
