"""Localizes a laser robot: the filter runs on the measurements that a bag has of it."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from app.engine.build import connect
from app.engine.follower import FilterState, Follower
from app.features.lab.localize.candidate import AVERAGED_UPDATES, Candidate
from app.features.lab.localize.contest import Contest, withdraw
from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.localized import Localized, ReportedPose
from app.features.lab.localize.reading.pairing import Measurement
from app.features.lab.localize.settings import LocalizeSettings
from app.features.lab.replay_robot import ReplayRobot
from app.settings.config import Config
from robot.driving.odometry import OdometryState
from robot.geometry import Pose2
from robot.interface import Frame, Reading, RobotError
from robot.localization.estimate import Belief, Estimate, Hypothesis, Integrity, State
from robot.scan import Scan


class GivenStart(NamedTuple):
    """The given start pose of the robot, in the map."""

    pose: Pose2
    sd_xy: float
    """[m]"""
    sd_theta: float
    """[rad]"""


class LaserFollower(Follower):
    """The filter of one laser robot on one map, which checks its own reports.

    It reports a pose while its best place is confirmed and explains the scans. If the place does
    not explain them well, the filter searches for other places. If one is better, the poses
    reported at the old place are withdrawn, except those that hindsight supports. So neither a
    wrong start nor a robot that was carried off stays unnoticed.
    """

    def __init__(
        self, laser_map: LaserMap, settings: LocalizeSettings, start: GivenStart | None, seed: int
    ) -> None:
        """Begin at the given start, or all over the free floor if there is none."""
        begun = time.perf_counter()
        self._map, self._settings = laser_map, settings
        self._sensor = laser_map.sensor(settings.localization.sensor, settings.laser)
        self._rng = np.random.default_rng(seed)
        self.found = Localized(tables_s=time.perf_counter() - begun)
        self._contest = Contest(self._new_candidate, settings.laser)
        self._telling = False
        self._asked: set[Pose2] = set()
        """Where the lasers sit whose scans were looked at since the robot moved."""
        if start is None:
            self._contest.begin_anywhere()
        else:
            spread = np.diag(np.square([start.sd_xy, start.sd_xy, start.sd_theta]))
            self._contest.begin_at(laser_map.map_from_cells.inverse() @ start.pose, spread)

    @property
    def shown(self) -> FilterState:
        """How many scans the leader used, and by which parameters."""
        return FilterState(updates=self.found.updates, parameters=self._settings.localization)

    def integrity_at(self, odom_from_robot: Pose2) -> Integrity:
        """Return the state that is claimed; there are no bounds."""
        return Integrity(self._state)

    def measure(self, seen: Frame | Scan, odometry: OdometryState) -> None:
        """Follow the robot to a scan."""
        assert isinstance(seen, Scan)  # a laser's robot has no camera
        begun = time.perf_counter()
        used = self._take(odometry.odom_from_robot, seen)
        if used:
            self._decide()
            if self._contest.places_left > self.found.places_left:
                self._withdraw()
        self.found.filter_s += time.perf_counter() - begun
        self.found.updates += used
        self._note(odometry.odom_from_robot, seen.stamp)

    def _take(self, odom_from_robot: Pose2, scan: Scan) -> bool:
        """Use a scan if it is due: after each motion the next one of each laser, as AMCL does."""
        laser = scan.robot_from_scan
        if self._contest.take(odom_from_robot, scan):
            self._asked = {laser}
            return True
        if not self._asked or laser in self._asked:
            return False
        self._asked.add(laser)
        return self._contest.take(odom_from_robot, scan, due=True)

    @property
    def _leader(self) -> Candidate:
        return self._contest.leader

    def _new_candidate(self) -> Candidate:
        return Candidate(self._map, self._sensor, self._settings, self._rng)

    def _decide(self) -> None:
        """Decide whether the leader's pose is reported until the next update."""
        leader, laser = self._leader, self._settings.laser
        floor = laser.tell_above if self._telling else laser.doubt_below
        given = leader.confirmed and leader.known and leader.deficit <= laser.doubt_behind / 4
        self._telling = given and leader.explains(floor)

    def _withdraw(self) -> None:
        """Withdraw reported poses of the old place, after another place turned out to be better."""
        contest = self._contest
        self.found.places_left = contest.places_left
        margin = self._settings.laser.doubt_behind / AVERAGED_UPDATES
        withdraw(self.found.reports, contest.moments, contest.copy_of_leader(), margin)

    @property
    def _state(self) -> State:
        leader = self._leader
        if self._telling:
            return State.CERTAIN
        if leader.confirmed and self.found.reports:
            return State.LOST
        if leader.known:
            return State.APPROXIMATE if self._contest.alone else State.AMBIGUOUS
        return State.SEARCHING

    def _note(self, odometry: Pose2, stamp: float) -> None:
        result, leader = self.found, self._leader
        result.particles = leader.particles
        given = None
        if leader.estimate is not None:
            pose = leader.map_from_odom @ odometry
            result.final = self._in_map(leader.estimate, pose, stamp)
            self.belief = Belief(result.final, odometry)
            if self._telling:
                position = result.final.pose.to_array()
                given = ReportedPose(stamp, position, odometry.to_array(), result.places_left)
        result.note(given, self._state, stamp)

    def _in_map(self, estimate: Estimate, pose2: Pose2, stamp: float) -> Estimate:
        """Return an estimate in the map's frame, moved on by odometry."""
        since = estimate.pose.inverse() @ pose2
        moved = tuple(
            Hypothesis(
                hypothesis.weight,
                self._map.pose_in_map(hypothesis.pose @ since),
                self._map.covariance_in_map(hypothesis.covariance),
            )
            for hypothesis in estimate.hypotheses
        )
        return Estimate(stamp, moved, estimate.effective)


def localize(
    measurements: Iterable[Measurement],
    laser_map: LaserMap,
    settings: LocalizeSettings,
    start: GivenStart | None,
    seed: int,
) -> Localized:
    """Follow a robot through its measurements; the same seed gives the same result."""
    follower = LaserFollower(laser_map, settings, start, seed)
    engine = connect(Config(), ReplayRobot("The bag", _readings(measurements)), follower)
    with contextlib.suppress(RobotError):  # the end of the bag
        while True:
            engine.step()
    return follower.found


def _readings(measurements: Iterable[Measurement]) -> Iterator[Reading]:
    """Yield a reading for each scan; what the joints do is not in a bag."""
    for odom_from_robot, scan in measurements:
        still = np.zeros(2)
        yield Reading(scan.stamp, still, still, scan=scan, odom_from_robot=odom_from_robot)
