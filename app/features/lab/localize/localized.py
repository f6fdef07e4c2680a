"""The result of localizing a bag: the reported poses, and which were withdrawn later."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field

from robot.geometry import Array
from robot.localization.estimate import Estimate, State

LONGEST_GAP = 1.0
"""Poses farther apart than this were not reported in one stretch [s]."""


@dataclass(eq=False)
class ReportedPose:
    """A pose that was reported as certain."""

    stamp: float
    """Stamp of its scan [s]."""
    pose: Array
    """(3,) in the map [m, m, rad]."""
    odometry: Array
    """(3,) in the odom frame, of the same scan."""
    leader: int
    """Number of the belief that reported it, from 0."""
    withdrawn: bool = False
    """Whether its place turned out to be wrong."""


@dataclass
class Localized:
    """The result of localizing a bag."""

    reports: list[ReportedPose] = field(default_factory=list)
    """All reported poses, also those withdrawn later."""
    states: Counter[State] = field(default_factory=Counter)
    """Number of scans by the state that was claimed."""
    state: State = State.SEARCHING
    """The state that is claimed at the end."""
    final: Estimate | None = None
    """The last estimate, in the map, moved to the last scan by odometry; None if there is none."""
    first_stamp: float = math.nan
    last_stamp: float = math.nan
    scans: int = 0
    updates: int = 0
    places_left: int = 0
    """How often another belief took the lead from a confirmed one."""
    particles: int = 0
    """Number of particles at the end."""
    filter_s: float = 0.0
    """Computing time of the updates."""
    tables_s: float = 0.0
    """Computing time of the map's tables."""

    @property
    def known(self) -> bool:
        """Whether the robot's place is known at the end."""
        return self.state is State.CERTAIN

    @property
    def standing(self) -> list[ReportedPose]:
        """The reported poses that still stand."""
        return [item for item in self.reports if not item.withdrawn]

    @property
    def withdrawn(self) -> list[ReportedPose]:
        """The reported poses whose places turned out to be wrong."""
        return [item for item in self.reports if item.withdrawn]

    @property
    def stamps(self) -> list[float]:
        """Stamps of the reported poses that still stand."""
        return [item.stamp for item in self.standing]

    @property
    def poses(self) -> list[Array]:
        """The reported poses (3,) that still stand, in the map."""
        return [item.pose for item in self.standing]

    @property
    def odometry(self) -> list[Array]:
        """Odometry (3,) of the reported poses that still stand, in the odom frame."""
        return [item.odometry for item in self.standing]

    def spans(self) -> list[tuple[float, float, int]]:
        """Return first stamp, last stamp [s] and belief of each stretch of withdrawn poses."""
        result: list[tuple[float, float, int]] = []
        before: ReportedPose | None = None
        for item in self.reports:
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
        """Total duration of the withdrawn stretches [s]."""
        return sum(last - first for first, last, _ in self.spans())

    def note(self, given: ReportedPose | None, state: State, stamp: float) -> None:
        """Record a scan, the state claimed at it, and the reported pose, if there is one."""
        if not self.scans:
            self.first_stamp = stamp
        self.scans += 1
        self.last_stamp = stamp
        self.state = state
        self.states[state] += 1
        if given is not None:
            self.reports.append(given)
