"""Adaptive Monte Carlo localization (Probabilistic Robotics, Tables 8.2 and 8.4; nav2_amcl)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robot.fields.field import Field
from robot.geometry import Array, Pose2, covariance_root, wrap_angle
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Cloud
from robot.localization.models.motion_models import MotionModel
from robot.localization.models.sensor_models import SensorModel
from robot.localization.parameters import FilterParameters
from robot.localization.particles.clusters import Cells, Clusters, find_clusters
from robot.localization.particles.resampling import (
    effective_sample_size,
    kld_sample_size,
    low_variance,
    regularize,
    temper,
)
from robot.scan import Scan


class ParticleFilter:
    """Particles that follow odometry and are weighed by scans."""

    def __init__(
        self,
        motion: MotionModel,
        sensor: SensorModel,
        field: Field,
        parameters: FilterParameters,
        rng: np.random.Generator,
        *,
        likelihood_weight: float = 1.0,
    ) -> None:
        self.motion = motion
        self.sensor = sensor
        self.field = field
        self.parameters = parameters
        self.likelihood_weight = likelihood_weight
        self._rng = rng
        self.set_pose(field.start, parameters.initial_covariance)

    @property
    def cloud(self) -> Cloud:
        """The cloud as the last scan weighed it, before resampling."""
        return self._weighed

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The cloud's clusters, heaviest first."""
        if self._moved:
            self._describe()
        return self._clusters.hypotheses

    @property
    def effective(self) -> float:
        """Effective sample size, before resampling."""
        return effective_sample_size(self._weighed.weights)

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        """Start anew around a pose in the map, with covariance (3, 3) [m, m, rad]."""
        noise = self._rng.standard_normal((self.parameters.most_particles, 3))
        poses = pose.to_array() + noise @ covariance_root(covariance).T
        poses[:, 2] = wrap_angle(poses[:, 2])
        self.set_cloud(Cloud.even(poses))

    def set_cloud(self, cloud: Cloud) -> None:
        """Start anew from given weighted particles."""
        self._particles = self._weighed = cloud
        self._describe()
        self._scans = 0

    def scatter(self) -> None:
        """Start anew, evenly over the free field."""
        self.set_cloud(Cloud.even(self.field.free_poses(self._rng, self.parameters.most_particles)))

    def predict(self, moved: Pose2) -> None:
        """Move each particle by odometry, and by chance."""
        poses = self.motion.sample(self._particles.poses, moved, self._rng)
        self._particles = self._weighed = replace(self._particles, poses=poses)
        self._moved = True

    def correct(self, scan: Scan) -> None:
        """Weigh the particles by a scan, and draw those that go on."""
        self._weigh(scan)
        self._describe()
        self._weighed = self._particles
        self._scans += 1
        if self._should_resample():
            self._resample()

    def _weigh(self, scan: Scan) -> None:
        if not scan.hit.any():
            return
        blurred = replace(scan, extra_sd=self._coarseness(scan))
        log_likelihood = self.sensor.log_likelihood(self._particles.poses, blurred)
        least = self.parameters.min_effective * len(self._particles.weights)
        weights = temper(log_likelihood, self._particles.weights, self.likelihood_weight, least)
        self._particles = replace(self._particles, weights=weights)

    def _coarseness(self, scan: Scan) -> float:
        """How far the particles of a cluster lie apart, as a spread of ranges [m].

        A likelihood narrower than that falls between them and none is right; so while the cloud
        is wide, ranges are believed that much less.
        """
        to_metres = float(np.median(scan.ranges[scan.hit]))
        apart = 0.0
        for one in self._clusters.hypotheses:
            count = max(one.weight * len(self._particles.weights), 1.0)
            volume = math.sqrt(max(np.linalg.det(one.covariance), 0.0)) * to_metres
            apart += one.weight * (volume / count) ** (1 / 3)
        return apart

    def _should_resample(self) -> bool:
        if self._scans % self.parameters.resample_interval:
            return False
        few = effective_sample_size(self._particles.weights) < 0.5 * len(self._particles.weights)
        return few or not self.parameters.selective_resampling

    def _resample(self) -> None:
        most = self.parameters.most_particles
        drawn = low_variance(self._particles.weights, most, self._rng)
        occupied = self._cells().occupied(self._particles.poses[drawn])
        wanted = kld_sample_size(occupied, self.parameters.pf_err, self.parameters.pf_z)
        count = min(max(wanted, self.parameters.min_particles), most)
        kept = low_variance(self._particles.weights, count, self._rng)
        spread = regularize(
            self._particles.poses[kept],
            self._clusters,
            self._clusters.labels[kept],
            self.parameters.regularization,
            self._rng,
        )
        self._particles = Cloud.even(spread)

    def _describe(self) -> None:
        poses, weights = self._particles.poses, self._particles.weights
        self._clusters: Clusters = find_clusters(poses, weights, self._cells())
        self._moved = False

    def _cells(self) -> Cells:
        turns = max(1, round(2 * math.pi / self.parameters.cell_theta))
        return Cells(self.parameters.cell_xy, turns)
