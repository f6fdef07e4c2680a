"""A candidate for a laser robot's place, and how well it explains the scans."""

from __future__ import annotations

import math

import numpy as np

from app.features.lab.localize.laser_map import LaserMap
from app.features.lab.localize.settings import LocalizeSettings
from robot.geometry import Array, Pose2
from robot.localization.estimate import Estimate
from robot.localization.filter import Cloud
from robot.localization.localizer import Localizer
from robot.localization.models.sensor_models import SensorModel, count_rays
from robot.localization.particles.particle_filter import ParticleFilter
from robot.scan import Scan

AVERAGED_UPDATES = 15
"""Number of updates in the running average of the fit."""
SEARCHING = 0.5
"""Factor on the weight of scans in a search, whose cloud must not settle on one of several
places."""
FEW = 0.2
"""Share of the particles that a place of a search begins with."""
CELL_M, CELL_RAD = 1.0, 0.5
"""Size of the cells in which the places of a search are looked for."""
APART_M, APART_RAD = 2.0, 0.8
"""Smallest distance between the places of a search."""
SAME_M, SAME_RAD = 1.0, 0.3
"""Places nearer than this are the same."""


class Candidate:
    """A particle filter that follows the robot, in the frame of the map's cells."""

    def __init__(
        self,
        laser_map: LaserMap,
        sensor: SensorModel,
        settings: LocalizeSettings,
        rng: np.random.Generator,
    ) -> None:
        p = settings.localization
        self._map, self._laser, self._sensor, self._rng = laser_map, settings.laser, sensor, rng
        self._belief = ParticleFilter(
            p.motion.model(), sensor, laser_map.field, p.filter, rng,
            likelihood_weight=p.sensor.likelihood_weight,
        )  # fmt: skip
        reach = p.sensor.laser_min_range, p.sensor.laser_max_range
        self._localizer = Localizer(self._belief, p.filter, reach=reach)
        self._reach = reach
        self.estimate: Estimate | None = None
        """The estimate after the last update."""
        self.map_from_odom = Pose2()
        self.known = False
        """Whether the belief is sure of one place."""
        self.fit = -math.inf
        """Running average of the log-likelihood per ray at its place, over the last updates."""
        self.latest = -math.inf
        """Log-likelihood per ray of the last update alone; -inf before the first."""
        self.sure = 0
        """Number of successive updates at which it was sure."""
        self.confirmed = False
        """Whether its place was given, or survived a search over the whole floor."""
        self.deficit = 0.0
        """By how much another place explains the scans better, summed over updates."""
        self._judged = 0
        self._way = 0.0
        self._odometry: Pose2 | None = None

    @property
    def updates(self) -> int:
        """Number of scans that were used."""
        return self._localizer.updates

    @property
    def stands(self) -> bool:
        """Whether it was sure for enough updates, moved far enough, and explains the scans."""
        laser = self._laser
        lasted = self.sure >= laser.known_updates and self._way >= laser.known_way
        return lasted and self.fit >= laser.doubt_below

    def explains(self, least: float) -> bool:
        """Whether its place explains the scans at least this well, or too few were judged yet."""
        return self._judged < self._laser.known_updates or self.fit >= least

    @property
    def particles(self) -> int:
        """Number of particles."""
        return len(self._belief.cloud.weights)

    def start_at(self, pose: Pose2, covariance: Array, odometry: Pose2 | None = None) -> None:
        """Start around a pose with covariance (3, 3) [m, m, rad].

        It is the pose at the given odometry, or at the next scan if there is none.
        """
        if odometry is not None:
            self._localizer.now, self._belief.share = odometry, FEW
        self._localizer.set_pose(pose, covariance)

    def start_anywhere(self) -> None:
        """Start all over the free floor, with particles enough for its area."""
        most = self._belief.parameters.most_particles
        wanted = round(self._laser.global_density * self._map.free_area)
        count = max(min(wanted, self._laser.global_most), most)
        self._belief.share = count / most
        self._belief.likelihood_weight *= SEARCHING
        self._localizer.set_cloud(Cloud.even(self._map.field.free_poses(self._rng, count)))

    def take(self, odometry: Pose2, scan: Scan) -> bool:
        """Follow the robot to a scan; return whether the scan was used."""
        estimate = self._localizer.update(odometry, scan)
        if estimate is None:
            return False
        best = estimate.hypotheses[0]
        self.estimate = estimate
        self.map_from_odom = best.pose @ odometry.inverse()
        widest = math.sqrt(max(float(np.linalg.eigvalsh(best.covariance[:2, :2])[-1]), 0.0))
        self.known = best.weight >= self._laser.known_share and widest <= self._laser.known_sd
        if self.known:
            self._belief.share = 1.0
        self.sure = self.sure + 1 if self.known else 0
        self._judge(best.pose, scan.within(*self._reach))
        self._way += odometry.distance_to(self._odometry or odometry)
        self._odometry = odometry
        return True

    def take_too(self, odometry: Pose2, scan: Scan) -> bool:
        """Follow the robot to a scan that counts after any motion; return whether it was used."""
        self._localizer.force_update()
        return self.take(odometry, scan)

    def _judge(self, pose: Pose2, scan: Scan) -> None:
        poses = pose.to_array()[None]
        rays = count_rays(self._sensor, poses, scan)
        if not rays:
            return
        self.latest = float(self._sensor.log_likelihood(poses, scan)[0]) / rays
        self._judged += 1
        share = 1 / min(self._judged, AVERAGED_UPDATES)
        self.fit = self.latest if share == 1 else self.fit + share * (self.latest - self.fit)

    def places(self, most: int) -> list[Pose2]:
        """Return the heaviest places of the whole cloud, apart from each other."""
        poses, weights = self._belief.cloud.poses, self._belief.cloud.weights
        cells = np.floor(poses / [CELL_M, CELL_M, CELL_RAD]).astype(np.int64)
        _, first, cell = np.unique(cells, axis=0, return_index=True, return_inverse=True)
        order = np.argsort(-np.bincount(cell, weights), kind="stable")
        pose2s: list[Pose2] = []
        for item in order:
            inside = cell == item
            offset = poses[inside] - poses[first[item]]
            middle = poses[first[item]] + np.average(offset, axis=0, weights=weights[inside])
            pose = Pose2.from_array(middle)
            if not any(_near(pose, other, APART_M, APART_RAD) for other in pose2s):
                pose2s.append(pose)
            if len(pose2s) == most:
                break
        return pose2s

    def same_place(self, other: Candidate) -> bool:
        """Whether another candidate is at the same place."""
        if self.estimate is None or other.estimate is None:
            return False
        return _near(self.estimate.pose, other.estimate.pose, SAME_M, SAME_RAD)


def _near(pose2: Pose2, other: Pose2, metres: float, radians: float) -> bool:
    return pose2.distance_to(other) < metres and abs(pose2.turn_to(other)) < radians
