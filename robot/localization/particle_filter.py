"""Adaptive Monte Carlo localization (Probabilistic Robotics, Tables 8.2 and 8.4; nav2_amcl)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.clusters import Cells, Clusters, find_clusters
from robot.localization.estimate import Estimate
from robot.localization.motion_models import MotionModel
from robot.localization.parameters import FilterParameters
from robot.localization.resampling import (
    effective_sample_size,
    kld_sample_size,
    low_variance,
    regularize,
    temper,
)
from robot.localization.sensor_models import SensorModel
from robot.scan import Scan


@dataclass(frozen=True, slots=True)
class Cloud:
    """Weighed particles."""

    poses: Array = field(repr=False)
    """(n, 3) [m, m, rad] in the map."""
    weights: Array = field(repr=False)
    """(n,), summing to one."""

    @classmethod
    def even(cls, poses: Array) -> Cloud:
        """Particles that all weigh the same."""
        return cls(poses, np.full(len(poses), 1.0 / len(poses)))


class ParticleFilter:
    """Particles that follow odometry and are weighed by scans."""

    def __init__(
        self,
        motion: MotionModel,
        sensor: SensorModel,
        parameters: FilterParameters,
        rng: np.random.Generator,
        *,
        likelihood_weight: float = 1.0,
    ) -> None:
        self.motion = motion
        self.sensor = sensor
        self.parameters = parameters
        self.likelihood_weight = likelihood_weight
        self.cloud = Cloud.even(np.zeros((parameters.min_particles, 3)))
        self._clusters = self._cluster()
        self.weighed = self.cloud
        """The cloud as the last measurement weighed it, before resampling: what is shown."""
        self.updates = 0
        """Measurements since the cloud was last made anew."""
        self._rng = rng
        self._odometry: Pose2 | None = None
        self._forced = True

    def set_pose(
        self, pose: Pose2, sd_xy: float | None = None, sd_theta: float | None = None
    ) -> None:
        """Start anew around a pose in the map, spread by standard deviations [m] and [rad]."""
        count = self.parameters.most_particles
        spread_xy = self.parameters.initial_sd_xy if sd_xy is None else sd_xy
        spread_theta = self.parameters.initial_sd_theta if sd_theta is None else sd_theta
        noise = self._rng.standard_normal((count, 3)) * (spread_xy, spread_xy, spread_theta)
        poses = pose.to_array() + noise
        poses[:, 2] = wrap_angle(poses[:, 2])
        self.set_particles(poses)

    def set_particles(self, poses: Array) -> None:
        """Start anew from given particles (n, 3), all of the same weight."""
        self.cloud = self.weighed = Cloud.even(poses)
        self._clusters = self._cluster()
        self.updates = 0
        # They are where the robot is now: what it drove before is in them already.
        self._odometry = None
        self._forced = True

    def force_update(self) -> None:
        """Let the next measurement count, however little the robot moves."""
        self._forced = True

    def predict(self, odometry: Pose2) -> bool:
        """Move the cloud by odometry alone: while measurements are paused.

        Returns whether it moved; it stays while the robot has hardly moved since the last time.

        Args:
            odometry: the robot in the odom frame.
        """
        moved = self._moved(odometry)
        due = self._is_due(moved)
        if due:
            self._propagate(odometry, moved)
            self._clusters = self._cluster()
            self.weighed = self.cloud
        return due

    def update(self, odometry: Pose2, scan: Scan) -> Estimate | None:
        """One step of the filter; None while the robot has hardly moved since the last one.

        Args:
            odometry: the robot in the odom frame, at the scan's stamp.
            scan: the measurement.
        """
        moved = self._moved(odometry)
        if not (self._forced or self._is_due(moved)):
            return None
        self._forced = False
        self._propagate(odometry, moved)
        self._weigh(scan)
        self._clusters = self._cluster()
        self.weighed = self.cloud
        self.updates += 1
        estimate = self.estimate(scan.stamp)
        if self._should_resample():
            self._resample()
        return estimate

    def estimate(self, stamp: float) -> Estimate:
        """What the cloud said when it was last weighed or made."""
        return Estimate(
            stamp, self._clusters.hypotheses, effective_sample_size(self.weighed.weights)
        )

    def _moved(self, odometry: Pose2) -> Pose2:
        if self._odometry is None:
            self._odometry = odometry
        return self._odometry.inverse() @ odometry

    def _is_due(self, moved: Pose2) -> bool:
        far = math.hypot(moved.x, moved.y) >= self.parameters.update_min_d
        return far or abs(moved.theta) >= self.parameters.update_min_a

    def _propagate(self, odometry: Pose2, moved: Pose2) -> None:
        # The window of odometry advances only here, so no motion is lost between updates.
        self._odometry = odometry
        self.cloud = replace(
            self.cloud, poses=self.motion.sample(self.cloud.poses, moved, self._rng)
        )

    def _weigh(self, scan: Scan) -> None:
        if not scan.hit.any():
            return
        blurred = replace(scan, extra_sd=self._coarseness(scan))
        log_likelihood = self.sensor.log_likelihood(self.cloud.poses, blurred)
        least = self.parameters.min_effective * len(self.cloud.weights)
        weights = temper(log_likelihood, self.cloud.weights, self.likelihood_weight, least)
        self.cloud = replace(self.cloud, weights=weights)

    def _coarseness(self, scan: Scan) -> float:
        """How far the particles of a cluster lie apart, as a spread of ranges [m].

        A likelihood narrower than that falls between them and none is right; so while the cloud
        is wide, ranges are believed that much less.
        """
        to_metres = float(np.median(scan.ranges[scan.hit]))
        apart = 0.0
        for one in self._clusters.hypotheses:
            count = max(one.weight * len(self.cloud.weights), 1.0)
            volume = math.sqrt(max(np.linalg.det(one.covariance), 0.0)) * to_metres
            apart += one.weight * (volume / count) ** (1 / 3)
        return apart

    def _should_resample(self) -> bool:
        if self.updates % self.parameters.resample_interval:
            return False
        few = effective_sample_size(self.cloud.weights) < 0.5 * len(self.cloud.weights)
        return few or not self.parameters.selective_resampling

    def _resample(self) -> None:
        most = self.parameters.most_particles
        drawn = low_variance(self.cloud.weights, most, self._rng)
        occupied = self._cells().occupied(self.cloud.poses[drawn])
        wanted = kld_sample_size(occupied, self.parameters.pf_err, self.parameters.pf_z)
        count = min(max(wanted, self.parameters.min_particles), most)
        kept = low_variance(self.cloud.weights, count, self._rng)
        spread = regularize(
            self.cloud.poses[kept],
            self._clusters,
            self._clusters.labels[kept],
            self.parameters.regularization,
            self._rng,
        )
        self.cloud = Cloud.even(spread)

    def _cluster(self) -> Clusters:
        return find_clusters(self.cloud.poses, self.cloud.weights, self._cells())

    def _cells(self) -> Cells:
        turns = max(1, round(2 * math.pi / self.parameters.cell_theta))
        return Cells(self.parameters.cell_xy, turns)
