"""Read the log of a CARMEN robot: a line of text for each message, such as ``FLASER``.

Many of the best known recordings of lasers are such logs.
"""

from __future__ import annotations

import gzip
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

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
OFFSET = "robot_frontlaser_offset"
"""Parameter that tells how far ahead of the robot's middle the laser sits [m]."""


def is_carmen_log(path: Path) -> bool:
    """Return whether a file is such a log, by its name."""
    return path.name.lower().endswith(ENDINGS)


def measurements(path: Path) -> Iterator[Measurement]:
    """Yield the scans of a log, each with the robot's pose by odometry.

    Raises:
        BagError: the file cannot be read, or has no scan; of a broken line it tells the number.
    """
    offset, has_scans = 0.0, False
    for number, line in enumerate(_lines(path), start=1):
        words = line.split()
        try:
            if words[:2] == ["PARAM", OFFSET]:
                offset = float(words[2])
            if words[:1] == ["FLASER"]:
                measured = _front_laser(words, offset)
            elif words[:1] == ["ROBOTLASER1"]:
                measured = _robot_laser(words)
            else:
                continue
        except (ValueError, IndexError) as error:
            raise BagError(f"{path}, line {number}: a broken {words[0]} message") from error
        has_scans = True
        yield measured
    if not has_scans:
        raise BagError(f"{path} has no scan; valid is a log with FLASER or ROBOTLASER1 messages")


def _lines(path: Path) -> Iterator[str]:
    opened = gzip.open if path.suffix == ".gz" else open
    try:
        with opened(path, "rt", encoding="utf-8") as file:
            yield from file
    except (OSError, EOFError, UnicodeDecodeError) as error:
        raise BagError(f"{path} cannot be read: {error}") from error


def _front_laser(words: list[str], offset: float) -> Measurement:
    """Return what ``FLASER n ranges laser-pose robot-pose stamp host stamp`` tells."""
    count = int(words[1])
    ranges = _numbers(words[2 : 2 + count], count)
    poses = _numbers(words[2 + count : 8 + count], 6)
    # 180 or 360 beams divide half a turn into as many parts; with 181 there is one at its end, too.
    fan = math.pi
    bearings = -fan / 2 + np.arange(count) * fan / (count - count % 2)
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
