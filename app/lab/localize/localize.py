"""A laser robot's measurements through the filter."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from app.lab.localize.candidate import REMEMBERED, Candidate
from app.lab.localize.contest import Contest
from app.lab.localize.hindsight import withdraw
from app.lab.localize.laser_map import LaserMap
from app.lab.localize.localized import Localized, ReportedPose
from app.lab.localize.reading.pairing import Measurement
from app.lab.localize.settings import LocalizeSettings
from robot.geometry import Pose2
from robot.localization.estimate import Estimate, Hypothesis
from robot.localization.integrity import State


class Start(NamedTuple):
    """Where the robot is told to be at first, in the map."""

    pose: Pose2
    sd_xy: float
    """[m]"""
    sd_theta: float
    """[rad]"""


class LaserFollower:
    """The filter of one laser robot on one map, which doubts itself.

    It tells where the robot is while one place is left, which stood the test, and explains the
    scans. Where it does not explain them well, others are searched for. If one is better, what was
    told of the old one is withdrawn, as far as hindsight cannot defend it. So neither a start that
    went wrong nor a robot that was carried stays unnoticed.
    """

    def __init__(
        self, laser_map: LaserMap, settings: LocalizeSettings, start: Start | None, seed: int
    ) -> None:
        """Start as told, or, without, all over the free floor."""
        begun = time.perf_counter()
        self._map, self._settings = laser_map, settings
        self._sensor = laser_map.sensor(settings.localization.sensor, settings.laser)
        self._rng = np.random.default_rng(seed)
        self.found = Localized(tables_s=time.perf_counter() - begun)
        self._contest = Contest(self._new_candidate, settings.laser)
        self._telling = False
        if start is None:
            self._contest.begin_anywhere()
        else:
            spread = np.diag(np.square([start.sd_xy, start.sd_xy, start.sd_theta]))
            self._contest.begin_at(laser_map.map_from_cells.inverse() @ start.pose, spread)

    def take(self, measurement: Measurement) -> None:
        """Follow the robot to a scan."""
        odometry, scan = measurement
        begun = time.perf_counter()
        used = self._contest.take(odometry, scan)
        if used:
            self._decide()
            if self._contest.places_left > self.found.places_left:
                self._withdraw()
        self.found.filter_s += time.perf_counter() - begun
        self.found.updates += used
        self._note(odometry, scan.stamp)

    @property
    def _leader(self) -> Candidate:
        return self._contest.leader

    def _new_candidate(self) -> Candidate:
        return Candidate(self._map, self._sensor, self._settings, self._rng)

    def _decide(self) -> None:
        """Whether the leader's place is told until the next update."""
        leader, laser = self._leader, self._settings.laser
        floor = laser.tell_above if self._telling else laser.doubt_below
        given = leader.confirmed and leader.known and leader.behind <= laser.doubt_behind / 4
        self._telling = given and leader.explains(floor)

    def _withdraw(self) -> None:
        """Another place is better: mark what was told of the old one."""
        contest = self._contest
        self.found.places_left = contest.places_left
        margin = self._settings.laser.doubt_behind / REMEMBERED
        withdraw(self.found.told, contest.moments, contest.copy_of_leader(), margin)

    @property
    def _state(self) -> State:
        leader = self._leader
        if self._telling:
            return State.CERTAIN
        if leader.confirmed and self.found.told:
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
            if self._telling:
                position = result.final.pose.to_array()
                given = ReportedPose(stamp, position, odometry.to_array(), result.places_left)
        result.note(given, self._state, stamp)

    def _in_map(self, estimate: Estimate, pose2: Pose2, stamp: float) -> Estimate:
        """An estimate in the map's frame, whose places have moved on by odometry."""
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
    start: Start | None,
    seed: int,
) -> Localized:
    """Follow a robot through its measurements; the same seed, the same result."""
    follower = LaserFollower(laser_map, settings, start, seed)
    for measurement in measurements:
        follower.take(measurement)
    return follower.found
