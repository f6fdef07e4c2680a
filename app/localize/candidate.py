"""One belief about where a laser robot is, and how well it explains what the laser sees."""

from __future__ import annotations

import math

import numpy as np

from app.localize.laser_map import LaserMap
from app.localize.settings import LocalizeSettings
from robot.geometry import Array, Pose2
from robot.localization.estimate import Estimate
from robot.localization.filter import Cloud
from robot.localization.localizer import Localizer
from robot.localization.models.sensor_models import SensorModel, count_rays
from robot.localization.particles.particle_filter import ParticleFilter
from robot.scan import Scan

REMEMBERED = 15
"""Updates that the running average of the fit goes back."""
SAME_M, SAME_RAD = 1.0, 0.3
"""Places nearer than this are one."""


class Candidate:
    """A particle filter that follows the robot; in the frame of the map's cells."""

    def __init__(
        self,
        on: LaserMap,
        sensor: SensorModel,
        settings: LocalizeSettings,
        rng: np.random.Generator,
    ) -> None:
        p = settings.localization
        self._map, self._laser, self._sensor, self._rng = on, settings.laser, sensor, rng
        self._belief = ParticleFilter(
            p.motion.model(), sensor, on.field, p.filter, rng,
            likelihood_weight=p.sensor.likelihood_weight,
        )  # fmt: skip
        reach = p.sensor.laser_min_range, p.sensor.laser_max_range
        self._localizer = Localizer(self._belief, p.filter, reach=reach)
        self._reach = reach
        self.estimate: Estimate | None = None
        """After the last update."""
        self.map_from_odom = Pose2()
        self.known = False
        """Whether it is sure of a place."""
        self.fit = -math.inf
        """Log-likelihood a ray at its place, on average over the last updates that it was sure."""
        self.sure = 0
        """How many of them there were, one after the other."""
        self.confirmed = False
        """Whether its place has stood the test of some scans, or was told."""

    @property
    def updates(self) -> int:
        """Scans that were taken."""
        return self._localizer.updates

    @property
    def particles(self) -> int:
        """How many it has."""
        return len(self._belief.cloud.weights)

    def start_at(self, pose: Pose2, covariance: Array) -> None:
        """Start around a pose, with covariance (3, 3) [m, m, rad]."""
        self._localizer.set_pose(pose, covariance)
        self.confirmed = True

    def start_anywhere(self) -> None:
        """Start all over the free floor, with so many particles that one is near any place."""
        most = self._belief.parameters.most_particles
        wanted = round(self._laser.global_density * self._map.free_area)
        count = max(min(wanted, self._laser.global_most), most)
        self._belief.share = count / most
        self._localizer.set_cloud(Cloud.even(self._map.field.free_poses(self._rng, count)))

    def take(self, odometry: Pose2, scan: Scan) -> bool:
        """Follow the robot to a scan; whether that was used."""
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
            self._judge(best.pose, scan.within(*self._reach))
        else:
            self.sure, self.fit = 0, -math.inf
        return True

    def _judge(self, pose: Pose2, scan: Scan) -> None:
        poses = pose.to_array()[None]
        rays = count_rays(self._sensor, poses, scan)
        if not rays:
            return
        fit = float(self._sensor.log_likelihood(poses, scan)[0]) / rays
        self.sure += 1
        share = 1 / min(self.sure, REMEMBERED)
        self.fit = fit if self.sure == 1 else self.fit + share * (fit - self.fit)
        if self.sure >= self._laser.known_updates and self.fit >= self._laser.doubt_below:
            self.confirmed = True

    def is_where(self, other: Candidate) -> bool:
        """Whether another is sure of the same place."""
        if self.estimate is None or other.estimate is None:
            return False
        mine, theirs = self.estimate.pose, other.estimate.pose
        return mine.distance_to(theirs) < SAME_M and abs(mine.turn_to(theirs)) < SAME_RAD
