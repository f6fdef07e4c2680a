"""A laser robot's measurements through the filter."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from app.localize.candidate import REMEMBERED, Candidate
from app.localize.laser_map import LaserMap
from app.localize.reading.pairing import Measurement
from app.localize.settings import LocalizeSettings
from robot.geometry import Array, Pose2
from robot.localization.estimate import Estimate, Hypothesis

FIRST_DOUBT, LAST_DOUBT = 10, 500
"""Updates before a rival may begin: at first, and at most after others that gave up."""
GIVES_UP = 300
"""Updates after which a rival that is not sure of any place gives up."""


class Start(NamedTuple):
    """Where the robot is told to be at first, in the map."""

    pose: Pose2
    sd_xy: float
    """[m]"""
    sd_theta: float
    """[rad]"""


@dataclass
class Localized:
    """What became of a bag."""

    stamps: list[float] = field(default_factory=list)
    """Of scans at which the robot's place was known."""
    poses: list[Array] = field(default_factory=list)
    """(3,) in the map, of the same."""
    odometry: list[Array] = field(default_factory=list)
    """(3,) in the odom frame, of the same."""
    final: Estimate | None = None
    """The last one, in the map, carried to the last scan by odometry; None if nothing came."""
    known: bool = False
    """Whether the robot's place is known at the end."""
    first_stamp: float = math.nan
    last_stamp: float = math.nan
    scans: int = 0
    updates: int = 0
    places_left: int = 0
    """How often a rival had the better place."""
    particles: int = 0
    """At the end."""
    filter_s: float = 0.0
    """Time that the updates took."""
    tables_s: float = 0.0
    """Time that the map's tables took."""


class LaserFollower:
    """The filter of one laser robot on one map, which doubts itself.

    Where the place that it is sure of does not explain the scans well, a rival starts from all over
    the floor. It takes the lead if it gets sure of another place that explains them better. So
    neither a start that went wrong nor a robot that was carried stays unnoticed; and a room that
    has changed since the map was made costs time alone.
    """

    def __init__(
        self, on: LaserMap, settings: LocalizeSettings, start: Start | None, seed: int
    ) -> None:
        """Start as told, or, without, all over the free floor."""
        begun = time.perf_counter()
        self._map, self._settings = on, settings
        self._sensor = on.sensor(settings.localization.sensor, settings.laser)
        self._rng = np.random.default_rng(seed)
        self.found = Localized(tables_s=time.perf_counter() - begun)
        self._leader = self._new_candidate()
        self._was_sure = False
        self._rival: Candidate | None = None
        self._patience = self._wait = FIRST_DOUBT
        if start is None:
            self._leader.start_anywhere()
        else:
            spread = np.diag(np.square([start.sd_xy, start.sd_xy, start.sd_theta]))
            self._leader.start_at(on.map_from_cells.inverse() @ start.pose, spread)

    def take(self, measurement: Measurement) -> None:
        """Follow the robot to a scan."""
        odometry, scan = measurement
        begun = time.perf_counter()
        used = self._leader.take(odometry, scan)
        if self._rival is not None:
            self._rival.take(odometry, scan)
        if used:
            self._doubt()
        self.found.filter_s += time.perf_counter() - begun
        self.found.updates += used
        self._note(odometry, scan.stamp)

    def _new_candidate(self) -> Candidate:
        return Candidate(self._map, self._sensor, self._settings, self._rng)

    def _doubt(self) -> None:
        """Let a rival begin, win or give up."""
        leader, laser = self._leader, self._settings.laser
        self._was_sure |= leader.known
        if self._rival is None:
            self._wait -= self._was_sure
            if self._wait <= 0 and leader.fit < laser.doubt_below:
                self._rival = self._new_candidate()
                self._rival.start_anywhere()
            return
        rival = self._rival
        agrees = rival.known and leader.known and rival.is_where(leader)
        if agrees or rival.updates > GIVES_UP:
            self._dismiss()
        elif rival.sure >= REMEMBERED and (leader.sure == 0 or leader.sure >= REMEMBERED):
            if rival.fit > leader.fit + laser.doubt_margin:
                self._leader, self._rival = rival, None
                rival.confirmed = True
                self._patience = self._wait = FIRST_DOUBT
                self.found.places_left += 1
            else:
                self._dismiss()

    def _dismiss(self) -> None:
        """The leader's place is the best there is, however badly it fits."""
        self._rival = None
        self._leader.confirmed = True
        self._patience = min(2 * self._patience, LAST_DOUBT)
        self._wait = self._patience

    def _note(self, odometry: Pose2, stamp: float) -> None:
        found, leader = self.found, self._leader
        if not found.scans:
            found.first_stamp = stamp
        found.scans += 1
        found.last_stamp = stamp
        found.particles = leader.particles
        found.known = leader.known and leader.confirmed
        if leader.estimate is None:
            return
        pose = leader.map_from_odom @ odometry
        found.final = self._in_map(leader.estimate, pose, stamp)
        if found.known:
            found.stamps.append(stamp)
            found.poses.append(found.final.pose.to_array())
            found.odometry.append(odometry.to_array())

    def _in_map(self, estimate: Estimate, now: Pose2, stamp: float) -> Estimate:
        """An estimate in the map's frame, whose places have moved on by odometry."""
        since = estimate.pose.inverse() @ now
        moved = tuple(
            Hypothesis(
                one.weight,
                self._map.pose_in_map(one.pose @ since),
                self._map.covariance_in_map(one.covariance),
            )
            for one in estimate.hypotheses
        )
        return Estimate(stamp, moved, estimate.effective)


def localize(
    measurements: Iterable[Measurement],
    on: LaserMap,
    settings: LocalizeSettings,
    start: Start | None,
    seed: int,
) -> Localized:
    """Follow a robot through its measurements; the same seed, the same result."""
    follower = LaserFollower(on, settings, start, seed)
    for measurement in measurements:
        follower.take(measurement)
    return follower.found
