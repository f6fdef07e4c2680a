"""What became of a bag: the poses that were told, and what hindsight says of them."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

from robot.geometry import Array
from robot.localization.estimate import Estimate
from robot.localization.integrity import State

LONGEST_GAP = 1.0
"""Poses farther apart than this were not told one after the other [s]."""


@dataclass
class ReportedPose:
    """A pose that was told as certain."""

    stamp: float
    """Of its scan [s]."""
    pose: Array
    """(3,) in the map [m, m, rad]."""
    odometry: Array
    """(3,) in the odom frame, of the same scan."""
    leader: int
    """Number of the belief that told it, from 0."""
    withdrawn: bool = False
    """Whether its place turned out wrong."""


@dataclass
class Localized:
    """What became of a bag."""

    told: list[ReportedPose] = field(default_factory=list)
    """All poses that were told, also those withdrawn later."""
    states: Counter[State] = field(default_factory=Counter)
    """Scans, by what was claimed at each."""
    state: State = State.SEARCHING
    """What is claimed at the end."""
    final: Estimate | None = None
    """The last one, in the map, carried to the last scan by odometry; None if nothing came."""
    first_stamp: float = math.nan
    last_stamp: float = math.nan
    scans: int = 0
    updates: int = 0
    places_left: int = 0
    """How often another belief had the better place."""
    particles: int = 0
    """At the end."""
    filter_s: float = 0.0
    """Time that the updates took."""
    tables_s: float = 0.0
    """Time that the map's tables took."""

    @property
    def known(self) -> bool:
        """Whether the robot's place is known at the end."""
        return self.state is State.CERTAIN

    @property
    def standing(self) -> list[ReportedPose]:
        """What was told and still stands."""
        return [item for item in self.told if not item.withdrawn]

    @property
    def withdrawn(self) -> list[ReportedPose]:
        """What was told of places that turned out wrong."""
        return [item for item in self.told if item.withdrawn]

    @property
    def stamps(self) -> list[float]:
        """Of scans at which the robot's place was known, and still stands."""
        return [item.stamp for item in self.standing]

    @property
    def poses(self) -> list[Array]:
        """(3,) in the map, of the same."""
        return [item.pose for item in self.standing]

    @property
    def odometry(self) -> list[Array]:
        """(3,) in the odom frame, of the same."""
        return [item.odometry for item in self.standing]

    def spans(self) -> list[tuple[float, float, int]]:
        """First and last stamp of what was withdrawn without a break, and who told it [s]."""
        result: list[tuple[float, float, int]] = []
        before: ReportedPose | None = None
        for item in self.told:
            if item.withdrawn and before is not None and before.withdrawn and (
                item.leader == before.leader and item.stamp - before.stamp <= LONGEST_GAP
            ):  # fmt: skip
                result[-1] = (result[-1][0], item.stamp, item.leader)
            elif item.withdrawn:
                result.append((item.stamp, item.stamp, item.leader))
            before = item
        return result

    @property
    def withdrawn_s(self) -> float:
        """How long places were told that were withdrawn [s]."""
        return sum(last - first for first, last, _ in self.spans())

    def note(self, given: ReportedPose | None, state: State, stamp: float) -> None:
        """A scan, what was claimed at it, and the pose that was told, if any was."""
        if not self.scans:
            self.first_stamp = stamp
        self.scans += 1
        self.last_stamp = stamp
        self.state = state
        self.states[state] += 1
        if given is not None:
            self.told.append(given)
