"""Read the log of a CARMEN robot: a line of text for each message, such as ``FLASER``.

Many of the best known recordings of lasers are such logs.
"""

from __future__ import annotations

import gzip
import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from app.features.lab.localize.reading.clocks import longest_rising
from app.features.lab.localize.reading.odometry import LEAST_SPEEDS
from app.features.lab.localize.reading.pairing import Measurement
from app.features.lab.localize.reading.sources import BagError
from robot.geometry import Array, Pose2
from robot.scan import Scan

ENDINGS = (".log", ".clf", ".log.gz", ".clf.gz")
NO_RETURN_M = 80.0
"""CARMEN writes the laser's greatest range for beams without a return; SICK's are 81.9 m."""
MOST_ALIKE = 8
"""The greatest range of other lasers is not known. But if this many beams have the same range, to
the centimetre, and it is the greatest of the scan, they met no wall."""
NOTHING = "has no scan; valid is a log with FLASER or ROBOTLASER1 messages"
LONGEST = 11
"""Most words of an ``FLASER`` line besides its ranges."""
APART_S = 86400.0
"""A log that goes on this much later is another one [s]: stamps that were cut to six digits step by
10,000 s."""
LASTING = 5
"""Clock and laser are others if so many scans on either side say so: single ones may be wrong."""
FARTHEST_M = 5.0
"""A robot that is farther from its last scan, and cannot have driven there in the time between, is
on another drive [m]; in the logs of the Intel lab and CSAIL no step is above 1.8 m."""
OFFSET = "robot_frontlaser_offset"
"""Parameter that tells how far ahead of the robot's middle the laser sits [m]."""


def is_carmen_log(path: Path) -> bool:
    """Return whether a file is such a log, by its name."""
    return path.name.lower().endswith(ENDINGS)


class CarmenLog:
    """Reads a log for what its scans say of their order, and then for the scans."""

    def __init__(self, path: Path) -> None:
        """Take a file, which is not read yet."""
        self._path = path
        self.remarks: list[str] = []
        """What was not as it should be, and what was done about it, in words."""

    def drives(self) -> Iterator[Iterator[Measurement]]:
        """Yield the scans of each drive, with the robot's pose by odometry; usually there is one.

        They are in the order of their lines: a logger writes what comes as it comes, so this is
        the order of time even where stamps do not rise, as in logs whose stamps were cut to six
        digits. The stamps of such scans are spread evenly between their neighbours'. Lines that
        are broken are left out.

        Raises:
            BagError: the file cannot be read, or has no whole scan; says which line is broken.
        """
        seen: list[_Seen] = []
        broken: list[tuple[int, str]] = []
        cut: str | None = None
        for number, read, is_begun in self._lines():
            if isinstance(read, Measurement):
                scan, pose = read.scan, read.odom_from_robot
                seen.append(_Seen(number, scan.stamp, pose, len(scan.bearings), is_begun))
            elif isinstance(read, ValueError):
                broken.append((number, str(read)))
            else:
                cut = f"the file is cut off or damaged after line {number} ({read})"
        first = "line {}: {}".format(*broken[0]) if broken else ""
        if not seen:
            raise BagError(f"{self._path}: {first or cut or NOTHING}")
        if cut is not None:
            self.remarks.append(f"{cut}: the {len(seen)} scans before it are used")
        if broken:
            self.remarks.append(f"broken lines that were left out: {len(broken)} ({first})")
        seen, set_back = with_steady_clock(seen)
        self.remarks += set_back
        starts = [0]
        for index, words in beginnings(seen):
            starts.append(index)
            self.remarks.append(f"line {seen[index].line}: another drive begins, as {words}")
        whole = (read for _, read, _ in self._lines() if isinstance(read, Measurement))
        for start, end in pairwise([*starts, len(seen)]):
            yield self._stamped(
                islice(whole, end - start), [each.stamp for each in seen[start:end]]
            )

    def _stamped(
        self, measured: Iterator[Measurement], stamps: list[float]
    ) -> Iterator[Measurement]:
        rising = longest_rising(stamps)
        if len(rising) < len(stamps):
            self.remarks.append(
                f"scans whose stamps do not rise: {len(stamps) - len(rising)} of {len(stamps)}; "
                "all are taken in the order of their lines, and these are stamped evenly between "
                "their neighbours"
            )
        for each, stamp in zip(measured, _spread(stamps, rising), strict=True):
            yield each._replace(scan=replace(each.scan, stamp=stamp))

    def _lines(self) -> Iterator[tuple[int, Measurement | ValueError | str, bool]]:
        """Yield the number of each line with a scan, the scan or what is wrong with it, and
        whether the head of a log stands before it.

        A text comes last, if the file ends before its end: it says why.
        """
        offset, number, is_begun, usual = 0.0, 0, False, dict[str, int]()
        opened = gzip.open if self._path.suffix == ".gz" else open
        try:
            with opened(self._path, "rt", encoding="utf-8", errors="replace") as file:
                for number, line in enumerate(file, start=1):
                    words = line.split()
                    kind = words[0] if words else ""
                    is_begun |= kind.startswith("#")
                    try:
                        if not line.endswith("\n") and len(words) < usual.get(kind, 0):
                            # Half of a number is a number, too.
                            yield number - 1, f"line {number} ends in its middle", False
                            return
                        if words[:2] == ["PARAM", OFFSET]:
                            offset = float(words[2])
                        elif kind == "FLASER":
                            yield number, _front_laser(words, offset), is_begun
                            is_begun, usual[kind] = False, len(words)
                        elif kind == "ROBOTLASER1":
                            yield number, _robot_laser(words), is_begun
                            is_begun, usual[kind] = False, len(words)
                    except (ValueError, IndexError):
                        yield number, ValueError(f"a broken {kind} message"), False
        except (OSError, EOFError, zlib.error) as error:
            if isinstance(error, OSError) and not number:
                raise BagError(f"{self._path} cannot be read: {error}") from error
            yield number, str(error), False


class _Seen(NamedTuple):
    """What a scan says of the order of a log."""

    line: int
    stamp: float
    pose: Pose2
    beams: int
    is_begun: bool
    """Whether a log's head stands before it."""


def with_steady_clock(seen: Sequence[_Seen]) -> tuple[list[_Seen], list[str]]:
    """Return scans as if no clock had been set back while the robot drove on; and where it was."""
    stamps = np.array([each.stamp for each in seen])
    steady, words, shift = [], [], 0.0
    for index, each in enumerate(seen):
        if index and _is_earlier(stamps, index) and _goes_on(seen, index):
            steps = np.diff(stamps[max(0, index - LASTING) : index])
            back = float(stamps[index - 1] - stamps[index])
            shift += back + (float(np.median(steps)) if len(steps) else 0.0)
            words.append(
                f"line {each.line}: the clock was set back by {back:.0f} s while the robot drove "
                "on: the stamps from there on are taken as later by that"
            )
        steady.append(each._replace(stamp=each.stamp + shift))
    return steady, words


def _is_earlier(stamps: Array, index: int) -> bool:
    """Return whether the stamps from one on are earlier than those before it, which rise."""
    before, after = stamps[max(0, index - LASTING) : index], stamps[index : index + LASTING]
    later = max(np.median(after) - np.median(before), after[0] - before[-1])
    return bool(later < 0 and all((np.diff(each) >= 0).all() for each in (before, after)))


def _goes_on(seen: Sequence[_Seen], index: int) -> bool:
    """Return whether the robot is no farther from where it was than in the scans around.

    Odometry of another drive begins at zero.
    """
    poses = [each.pose for each in seen[max(0, index - LASTING) : index + LASTING]]
    place = min(index, LASTING)
    steps = [before.distance_to(after) for before, after in pairwise(poses)]
    step = steps.pop(place - 1)
    return poses[place] != Pose2() and step <= max(steps, default=0.0)


def beginnings(seen: Sequence[_Seen]) -> Iterator[tuple[int, str]]:
    """Yield which scans are the first of another drive, and why: several logs may be in a file."""
    stamps = np.array([each.stamp for each in seen])
    beams = [each.beams for each in seen]
    for index in range(1, len(seen)):
        before, this = seen[index - 1], seen[index]
        lasers = set(beams[max(0, index - LASTING) : index]), set(beams[index : index + LASTING])
        around = stamps[max(0, index - LASTING) : index], stamps[index : index + LASTING]
        later = float(np.median(around[1]) - np.median(around[0]))
        far, time = before.pose.distance_to(this.pose), this.stamp - before.stamp
        if this.is_begun:
            yield index, "it has a log's head"
        elif lasers[0] != lasers[1] and all(len(each) == 1 for each in lasers):
            yield index, f"a laser with {this.beams} beams follows one with {before.beams}"
        elif min(time, later) > APART_S:
            yield index, f"it is {time / 86400:.0f} days later"
        elif _is_earlier(stamps, index):
            yield index, f"its clock is {-time:.0f} s earlier"
        elif far > FARTHEST_M and not far < LEAST_SPEEDS[0] * time:
            yield index, f"the robot is {far:.1f} m away, where it cannot have driven"


def _spread(stamps: list[float], rising: list[int]) -> list[float]:
    """Return all stamps, where only some are right: the others lie evenly between these [s]."""
    steps = np.diff([stamps[index] for index in rising]) / np.diff(rising)
    step = float(np.median(steps)) if len(steps) else 1.0
    first, last = rising[0], rising[-1]
    known = [stamps[first] - first * step, *(stamps[index] for index in rising)]
    known.append(stamps[last] + (len(stamps) - last) * step)
    places = [0 if first else -1, *rising, len(stamps)]
    return np.interp(np.arange(len(stamps)), places, known).tolist()


def _front_laser(words: list[str], offset: float) -> Measurement:
    """Return what ``FLASER n ranges laser-pose robot-pose stamp host stamp`` tells."""
    count = int(words[1])
    ranges = _numbers(words[2 : 2 + count], count)
    poses = _numbers(words[2 + count : 8 + count], 6)
    if len(words) > LONGEST + count:
        raise ValueError(f"{len(words)} words for {count} ranges")
    # 180 or 360 beams divide half a turn into as many parts; with 181 there is one at its end, too.
    fan = math.pi
    bearings = -fan / 2 + np.arange(count) * fan / max(count - count % 2, 1)
    measured = _measurement(float(words[8 + count]), bearings, ranges, poses)
    if measured.scan.robot_from_scan == Pose2():
        mounted = replace(measured.scan, robot_from_scan=Pose2(offset, 0.0, 0.0))
        return measured._replace(scan=mounted)
    return measured


def _robot_laser(words: list[str]) -> Measurement:
    """Return what ``ROBOTLASER1`` tells: kind, first angle, view, step, range, and so on."""
    first, _, step, farthest = _numbers(words[2:6], 4)
    count = int(words[8])
    ranges = _numbers(words[9 : 9 + count], count)
    after = 10 + count + int(words[9 + count])
    poses = _numbers(words[after : after + 6], 6)
    bearings = first + step * np.arange(count)
    ranges = np.where(ranges < farthest, ranges, np.inf)
    return _measurement(float(words[-3]), bearings, ranges, poses)


def _measurement(stamp: float, bearings: Array, ranges: Array, poses: Array) -> Measurement:
    if not math.isfinite(stamp):
        raise ValueError(f"a stamp of {stamp}")
    laser, robot = Pose2(*poses[:3].tolist()), Pose2(*poses[3:].tolist())
    farthest = ranges.max(initial=0.0)
    if np.count_nonzero(ranges == farthest) < MOST_ALIKE:
        farthest = NO_RETURN_M
    seen = np.where((ranges > 0) & (ranges < min(farthest, NO_RETURN_M)), ranges, np.inf)
    return Measurement(robot, Scan(stamp, bearings, seen, robot.inverse() @ laser))


def _numbers(words: list[str], count: int) -> Array:
    """Return words as numbers.

    Raises:
        ValueError: there are fewer, or one is none.
    """
    values = np.array(words, np.float64)
    if len(values) != count or not np.isfinite(values).all():
        raise ValueError(f"{len(values)} of {count} numbers")
    return values
