"""Make one rising clock of the stamps of a bag, whichever clocks were wrong or set back meanwhile.

The messages of all topics are looked at before the first is used, so what comes after a doubtful
stamp decides what it was: one wrong stamp, which is left out alone; or a clock that was set back,
which is counted on from there. A recorder's clock that was set back shows in the file's own order.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robot.geometry import Array

NEIGHBOURS = 10
"""Number of messages on either side that a stamp is compared with."""
FEWEST = 5
"""Least number of messages on either side of a step; fewer are single mistakes."""
LEAST_STEP_S = 0.15
"""Smallest step back of a clock that is looked for [s]; smaller ones cost a message or two."""
JUMP_S = 10.0
"""A stamp is wrong if it is off by more than this: no message takes that long [s]."""
MISTAKE_S = 1.0
"""So is a stamp that is off by more than this, alone among others that are not [s]."""
LEAST_RATE = 0.2
"""A clock whose rate differs from 1 by less than this runs as time does."""
SAME_STEP_S = 0.5
"""Steps of two topics that differ by less than this [s] are those of one clock."""
REPEATED = 0.9
"""A bag was played again if this share of the messages after a step back came before, too."""


@dataclass
class Stream:
    """The messages of one topic, in the order of the file."""

    numbers: list[int] = field(default_factory=list)
    """Number of each message in the file, counted over all streams."""
    logged: list[float] = field(default_factory=list)
    """When it was recorded [s]."""
    stamps: list[float] = field(default_factory=list)
    """As its header says [s]; 0 if it has none."""
    contents: list[int] = field(default_factory=list)
    """A fingerprint of each content."""

    def add(self, number: int, logged: float, stamp: float, content: int) -> None:
        """Append a message."""
        self.numbers.append(number)
        self.logged.append(logged)
        self.stamps.append(stamp)
        self.contents.append(content)


@dataclass(frozen=True, eq=False)
class TopicTimeline:
    """The messages of one topic on the one clock of the bag."""

    order: NDArray[np.intp]
    """(n,) Place in the stream, in the order in which they are read."""
    stamps: Array
    """(n,) Stamps [s]; nan of messages that are left out. The others rise."""
    arrivals: Array
    """(n,) When each was recorded, by a clock that is not set back [s]."""
    repeats: int = 0
    """Number of messages that came before, as the bag was played again."""

    def lag(self) -> float:
        """Return by how much stamps are at least behind the times of recording [s]."""
        lags = (self.arrivals - self.stamps)[~np.isnan(self.stamps)]
        return float(np.quantile(lags, 0.1)) if len(lags) else math.nan


@dataclass(frozen=True)
class Clocks:
    """The streams of a bag on one clock."""

    timelines: dict[str, TopicTimeline]
    """By the names of the streams."""
    as_written: bool
    """Whether the bag has to be read in the file's own order."""
    remarks: list[str]
    """Which clocks were set back, in words."""


class RecorderStep(NamedTuple):
    """The recorder's clock was set back."""

    number: int
    """The first message after it."""
    size: float
    """By how much [s]."""


class HeaderStep(NamedTuple):
    """A clock that gives stamps was set back."""

    moment: float
    """When the first message after it was recorded [s]."""
    size: float
    """By how much [s]."""


def one_clock(streams: Mapping[str, Stream], *, by_log: bool) -> Clocks:
    """Return the streams on one clock: that of the headers, or that of the recorder."""
    steps = _recorder_steps(streams)
    remarks = [
        f"the recorder's clock was set back by {step.size:.1f} s; messages are taken in the file's "
        "own order"
        for step in steps
    ]
    orders, arrivals = {}, {}
    for name, stream in streams.items():
        logged, numbers = np.array(stream.logged), np.array(stream.numbers)
        order = np.arange(len(logged)) if steps else np.argsort(logged, kind="stable")
        for step in steps:
            logged = logged + np.where(numbers >= step.number, step.size, 0.0)
        orders[name], arrivals[name] = order, logged[order]
    if by_log:
        lines = {
            name: TopicTimeline(orders[name], _only_rising(arrivals[name]), arrivals[name])
            for name in streams
        }
        return Clocks(lines, bool(steps), remarks)
    timelines: dict[str, TopicTimeline] = {}
    owners: dict[HeaderStep, list[str]] = {}
    for name in sorted(streams, key=lambda name: -len(streams[name].numbers)):
        timelines[name], header_steps = _by_headers(
            streams[name], orders[name], arrivals[name], list(owners)
        )
        for header_step in header_steps:
            owners.setdefault(header_step, []).append(name)
    begin = min((times[0] for times in arrivals.values() if len(times)), default=0.0)
    remarks += [
        f"the clock of {' and '.join(names)} was set back by {size:.1f} s, {moment - begin:.1f} s "
        "after the beginning; what follows is counted on from there"
        for (moment, size), names in owners.items()
    ]
    remarks += [
        f"{times.repeats} messages of {name} came before with the same stamps, as in a bag that is "
        "played again; they were left out"
        for name, times in timelines.items()
        if times.repeats
    ]
    return Clocks(timelines, bool(steps), remarks)


def _recorder_steps(streams: Mapping[str, Stream]) -> list[RecorderStep]:
    """Return where the recorder's clock was set back.

    Within one topic the times of recording do not fall. Between topics they may: a file can hold
    one topic after the other.
    """
    main = max(streams.values(), key=lambda stream: len(stream.numbers), default=Stream())
    logged = np.array(main.logged)
    if len(logged) < 2:
        return []
    between = np.diff(logged)
    usual = float(np.median(between[between > 0])) if (between > 0).any() else 0.0
    least = max(LEAST_STEP_S, 3 * usual)
    result = []
    pooled = sorted(
        pair
        for stream in streams.values()
        for pair in zip(stream.numbers, stream.logged, strict=True)
    )
    numbers = [number for number, _ in pooled]
    for index, _ in _steps_back(logged, usual * np.arange(len(logged), dtype=np.float64), least):
        # Messages of other topics may lie between the last before the step and the first after it.
        first = bisect_left(numbers, main.numbers[index - 1])
        last = bisect_left(numbers, main.numbers[index])
        moments = [moment for _, moment in pooled[first : last + 1]]
        number = numbers[first + 1 + int(np.argmin(np.diff(moments)))]
        sizes = [_gap_back(stream, number) for stream in streams.values()]
        size = float(np.median([each for each in sizes if each is not None] or [0.0]))
        if size >= least:
            result.append(RecorderStep(number, size))
    return result


def _gap_back(stream: Stream, number: int) -> float | None:
    """Return by how much [s] a stream's times are behind where they would have gone on."""
    index = bisect_left(stream.numbers, number)
    if not FEWEST <= index < len(stream.numbers):
        return None
    logged = np.array(stream.logged[max(index - NEIGHBOURS, 0) : index + NEIGHBOURS])
    usual = float(np.median(np.diff(logged)))
    return stream.logged[index - 1] + usual - stream.logged[index]


def _steps_back(clock: Array, reference: Array, least: float) -> list[tuple[int, float]]:
    """Return where a clock was set back, and by how much [s].

    It falls there, and what comes after it is behind what came before, by the reference.
    """
    ahead = clock - reference
    chosen: list[tuple[int, float, float]] = []
    for index in (np.flatnonzero(np.diff(clock) < 0) + 1).tolist():
        before = ahead[max(index - NEIGHBOURS, 0) : index]
        after = ahead[index : index + NEIGHBOURS]
        if min(len(before), len(after)) < FEWEST:
            continue
        middles = float(np.median(before)), float(np.median(after))
        size = middles[0] - middles[1]
        if size < least:
            continue
        cost = float(np.abs(before - middles[0]).sum() + np.abs(after - middles[1]).sum())
        if chosen and index - chosen[-1][0] < NEIGHBOURS:  # one step, beside wrong stamps
            if cost < chosen[-1][2]:
                chosen[-1] = index, size, cost
        else:
            chosen.append((index, size, cost))
    return [(index, size) for index, size, _ in chosen]


def _by_headers(
    stream: Stream, order: NDArray[np.intp], arrivals: Array, known: Sequence[HeaderStep]
) -> tuple[TopicTimeline, list[HeaderStep]]:
    """Return a stream by the stamps of its headers, and when its clock was set back by how much.

    Args:
        stream: the messages.
        order: in which they are read.
        arrivals: when they were recorded, in that order [s].
        known: steps that were seen in other streams.
    """
    stamps = np.array(stream.stamps)[order]
    absent = ~(stamps > 0)
    if absent.sum() > len(stamps) / 2:  # the driver has no clock
        return TopicTimeline(order, _only_rising(arrivals), arrivals), []
    given = np.flatnonzero(~absent)
    clock, moments = stamps[given], arrivals[given]
    contents = np.array(stream.contents)[order][given]
    steps: list[HeaderStep] = []
    repeated = np.zeros(len(clock), dtype=bool)
    reference = _rate(clock, moments) * moments
    boundaries = [*_steps_back(clock, reference, LEAST_STEP_S), (len(clock), 0.0)]
    shift = np.zeros(len(clock))
    for (index, size), (end, _) in pairwise(boundaries):
        earlier = set(zip(clock[:index].tolist(), contents[:index].tolist(), strict=True))
        later = zip(clock[index:end].tolist(), contents[index:end].tolist(), strict=True)
        if np.mean([pair in earlier for pair in later]) >= REPEATED:
            repeated[index:end] = True
            continue
        moment = float(moments[index])
        same = [
            step
            for step in known
            if abs(step.moment - moment) <= JUMP_S and abs(step.size - size) <= SAME_STEP_S
        ]
        steps.append(same[0] if same else HeaderStep(moment, size))
        shift[index:] += steps[-1].size
    clock = clock + shift
    usable = np.flatnonzero(~repeated)
    usable = usable[~_mistakes((clock - reference)[usable])]
    result = np.full(len(stamps), np.nan)
    result[given[usable]] = _only_rising(clock[usable])
    return TopicTimeline(order, result, arrivals, int(repeated.sum())), steps


def _rate(clock: Array, moments: Array) -> float:
    """Return how fast a clock runs; that of a simulation may run slower or faster than time."""
    stride = max(NEIGHBOURS, len(clock) // 20)
    ticks, passed = clock[stride:] - clock[:-stride], moments[stride:] - moments[:-stride]
    rises = (ticks > 0) & (passed > 0)
    rate = float(np.median(ticks[rises] / passed[rises])) if rises.any() else 1.0
    return 1.0 if abs(rate - 1) < LEAST_RATE else rate


def _mistakes(ahead: Array) -> NDArray[np.bool_]:
    """Return which stamps fit neither those before nor those after, by their lead on arrivals.

    A network that holds messages back makes the lead fall, and rise again from one message to the
    next. A mistake is alone.
    """
    result = np.zeros(len(ahead), dtype=bool)
    jumps = np.flatnonzero(np.abs(np.diff(ahead)) > MISTAKE_S)
    for index in sorted({*jumps.tolist(), *(jumps + 1).tolist()}):
        own = ahead[index]
        before = ahead[max(index - NEIGHBOURS, 0) : index]
        after = ahead[index + 1 : index + 1 + NEIGHBOURS]
        nearest = [*before[-1:], *after[:1]]
        middles = [float(np.median(side)) for side in (before, after) if len(side)]
        alone = all(abs(other - own) > MISTAKE_S for other in nearest)
        outside = not min(middles) - MISTAKE_S <= own <= max(middles) + MISTAKE_S
        far = all(abs(middle - own) > JUMP_S for middle in middles)
        result[index] = far or (alone and outside)
    return result


def _only_rising(stamps: Array) -> Array:
    """Return stamps with nan in place of those that have to go so that the others rise."""
    if (np.diff(stamps) > 0).all():
        return stamps
    result = np.full(len(stamps), np.nan)
    kept = longest_rising(stamps.tolist())
    result[kept] = stamps[kept]
    return result


def longest_rising(stamps: Sequence[float]) -> list[int]:
    """Return the indices of the longest rising part, so that a wrong stamp costs itself alone."""
    tails: list[float] = []
    last: list[int] = []
    before: list[int] = []
    for index, stamp in enumerate(stamps):
        length = bisect_left(tails, stamp)
        before.append(last[length - 1] if length else -1)
        tails[length : length + 1] = [stamp]
        last[length : length + 1] = [index]
    result: list[int] = []
    index = last[-1] if last else -1
    while index >= 0:
        result.append(index)
        index = before[index]
    return result[::-1]
