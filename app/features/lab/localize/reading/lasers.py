"""All lasers of a robot that are read from its bag: each has its own topic, mounting and delay."""

from __future__ import annotations

import argparse
import heapq
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.layout import BagNames, Chosen, Layout, choose, find_layout
from app.features.lab.localize.reading.pairing import SCANS, Measurement, Pairing, SkippedCounts
from robot.geometry import Pose2
from robot.settings import SettingError

APART_S = 1e-6
"""Scans of two lasers at the same moment get stamps that differ by this [s], so that all rise."""


@dataclass(frozen=True)
class BagLaser:
    """One laser of a robot in a bag."""

    chosen: Chosen
    layout: Layout

    @property
    def words(self) -> list[str]:
        """Return what is read, for people."""
        chosen, layout = self.chosen, self.layout
        lines = [
            f"{chosen.scan} and {chosen.odometry or 'tf'}, laser as told by {layout.pose_from}"
        ]
        if layout.assumed:
            lines.append(
                "so the laser is taken to sit at the robot's middle, looking ahead (--laser-pose)"
            )
        return lines


def find_lasers(bag: Bag, parsed: argparse.Namespace) -> tuple[BagLaser, ...]:
    """Return the lasers that the options of `add_topics` name, or the only one of a bag.

    Raises:
        SettingError, BagError: says what cannot be used, and what there is.
    """
    topics: Sequence[str | None] = parsed.scan_topic or [None]
    poses: Sequence[Sequence[float]] = parsed.laser_pose or []
    if poses and len(poses) != len(topics):
        raise SettingError(
            f"--laser-pose is there {len(poses)} times; valid is once for each laser ("
            f"{len(topics)}), in the order of --scan-topic"
        )
    for pose in poses:
        if not all(math.isfinite(value) for value in pose):
            raise SettingError(f"--laser-pose is {list(pose)}; valid are three finite numbers")
    names = BagNames.of(parsed.odom_frame, parsed.base_frame, parsed.namespace)
    result = []
    for topic, pose in zip_longest(topics, poses):
        chosen = choose(bag, topic, parsed.odom_topic, names)
        layout = find_layout(bag, chosen, None if pose is None else Pose2(*pose), names)
        result.append(BagLaser(chosen, layout))
    if len({laser.chosen.scan for laser in result}) < len(result):
        raise SettingError("--scan-topic names a topic twice; valid is each laser's once")
    return tuple(result)


class Lasers:
    """The scans of all lasers by their stamps, each with the robot's pose by odometry."""

    def __init__(
        self,
        bag: Bag,
        lasers: Sequence[BagLaser],
        clock: str = "header",
        across: float | None = None,
    ) -> None:
        """Prepare to read; the arguments are those of `Pairing`."""
        self.lasers = tuple(lasers)
        self._pairings = [
            Pairing(bag, laser.chosen, laser.layout, clock, across) for laser in lasers
        ]

    def measurements(self) -> Iterator[Measurement]:
        """Yield all scans that can be used; their stamps rise.

        Raises:
            BagError: the bag is damaged, or has lengths or angles in another unit.
        """
        newest = -math.inf
        each = [pairing.measurements() for pairing in self._pairings]
        for pose, scan in heapq.merge(*each, key=lambda measured: measured.scan.stamp):
            stamp = max(scan.stamp, newest + APART_S)
            newest = stamp
            yield Measurement(pose, scan if stamp == scan.stamp else replace(scan, stamp=stamp))

    @property
    def total(self) -> int:
        """Number of messages to read."""
        return sum(pairing.total for pairing in self._pairings)

    @property
    def messages(self) -> int:
        """Number of messages read so far."""
        return sum(pairing.messages for pairing in self._pairings)

    @property
    def left_out(self) -> SkippedCounts:
        """What could not be used; odometry is the same for all lasers."""
        counts = [pairing.left_out for pairing in self._pairings]
        return SkippedCounts(
            unusable_scans=sum(each.unusable_scans for each in counts),
            out_of_order=sum(each.out_of_order for each in counts),
            without_odometry=sum(each.without_odometry for each in counts),
            odometry=max(each.odometry for each in counts),
            absurd_odometry=max(each.absurd_odometry for each in counts),
        )

    @property
    def clocks(self) -> dict[str, tuple[float, float]]:
        """First and last stamp [s] of each laser's scans, and of odometry."""
        result: dict[str, tuple[float, float]] = {}
        for laser, pairing in zip(self.lasers, self._pairings, strict=True):
            for name, span in pairing.clocks.items():
                several = name == SCANS and len(self.lasers) > 1
                result[f"{name} on {laser.chosen.scan}" if several else name] = span
        return result

    @property
    def remarks(self) -> list[str]:
        """What was not as it should be, and what was done about it, in words."""
        first, *others = (pairing.remarks for pairing in self._pairings)
        common = [words for words in first if all(words in other for other in others)]
        return common + [
            f"{laser.chosen.scan}: {words}"
            for laser, pairing in zip(self.lasers, self._pairings, strict=True)
            for words in pairing.remarks
            if words not in common
        ]
