"""The particle filter: AMCL (Probabilistic Robotics, Tables 8.2 and 8.4; nav2_amcl)."""

from __future__ import annotations

import math

import numpy as np

from robot.fields.field import Field
from robot.geometry import Array, Pose2, covariance_root, wrap_angle
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.filter import Cloud, Setup
from robot.localization.kernels.sampling import count_cells
from robot.localization.models.motion_models import MotionModel, loosened
from robot.localization.models.sensor_models import SensorModel, count_rays
from robot.localization.parameters import FilterParameters
from robot.localization.particles.clusters import Cells, Clusters, find_clusters
from robot.localization.particles.resampling import (
    Recovery,
    Resampled,
    coarseness,
    effective_sample_size,
    kld_sample_size,
    low_variance,
    regularize,
    temper,
)
from robot.scan import Scan

FEWEST = 10
"""The filter never has fewer particles."""


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
        share: float = 1.0,
    ) -> None:
        self.motion = motion
        self.looseness = 1.0
        """Factor on the motion model's standard deviations."""
        self.sensor = sensor
        self.field = field
        self.parameters = parameters
        self.likelihood_weight = likelihood_weight
        self.share = share
        """Factor on the number of particles: below 1 for one of several tracks, above 1 while the
        robot may be anywhere on a large map."""
        self.extra_sd = 0.0
        """Standard deviation that was added to the last ranges, as particles lie apart [m]."""
        self._rng = rng
        self.set_pose(field.start, parameters.initial_covariance)

    @classmethod
    def of(cls, setup: Setup, rng: np.random.Generator, share: float = 1.0) -> ParticleFilter:
        """Return a filter with the models and parameters of a setup, and a share of particles."""
        return cls(
            setup.motion,
            setup.sensor,
            setup.field,
            setup.filter,
            rng,
            likelihood_weight=setup.likelihood_weight,
            share=share,
        )

    @property
    def standing(self) -> Standing:
        """Always confirmed: it makes no search; one beside it judges its place (SearchBeside)."""
        return Standing.CONFIRMED

    def search_anew(self) -> None:
        """Change nothing, because this filter does not search for other places."""

    def use(self, setup: Setup) -> None:
        """Switch to other models and parameters, and keep the particles."""
        self.motion, self.sensor = setup.motion, setup.sensor
        self.parameters, self.likelihood_weight = setup.filter, setup.likelihood_weight

    def loosen(self, factor: float) -> None:
        """Multiply the motion model's standard deviations by a factor from now on."""
        self.looseness = factor

    @property
    def cloud(self) -> Cloud:
        """The cloud after the last scan's weights, before resampling."""
        return self._weighed

    @property
    def particles(self) -> Cloud:
        """The cloud that the next step moves: after resampling, the copies."""
        return self._particles

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
        """Restart around a pose in the map, with covariance (3, 3) [m, m, rad]."""
        noise = self._rng.standard_normal((self._limits()[1], 3))
        poses = pose.to_array() + noise @ covariance_root(covariance).T
        poses[:, 2] = wrap_angle(poses[:, 2])
        self.set_cloud(Cloud.even(poses))

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Restart at hypotheses; only the ratios of their weights count."""
        self.set_cloud(Cloud.drawn(hypotheses, self._limits()[1], self._rng))

    def set_cloud(self, cloud: Cloud) -> None:
        """Restart from given weighted particles."""
        self._particles = self._weighed = cloud
        self._describe()
        self._scans = 0
        self._recovery = Recovery()

    def scatter(self) -> None:
        """Restart evenly over the free field."""
        self.set_cloud(Cloud.even(self.field.free_poses(self._rng, self._limits()[1])))

    def predict(self, moved: Pose2) -> None:
        """Move each particle by odometry, with noise of the motion model."""
        poses = loosened(self.motion, self.looseness).sample(
            self._particles.poses, moved, self._rng
        )
        self._particles = self._weighed = Cloud(poses, self._particles.weights)
        self._moved = True

    def correct(self, scan: Scan) -> None:
        """Weigh the particles by a scan, and resample them if that is due."""
        self.weigh(scan)
        if self._should_resample():
            self.resample()

    def weigh(self, scan: Scan) -> None:
        """Weigh the particles by a scan, and describe their clusters."""
        self._multiply(scan)
        self._describe()
        self._weighed = self._particles
        self._scans += 1

    def _multiply(self, scan: Scan) -> None:
        """Multiply each weight by the likelihood of a scan, and normalize them."""
        poses, weights = self._particles.poses, self._particles.weights
        # The clusters are those of the last scan: they move and widen little in between.
        known, settings = self._clusters, self.parameters
        apart, returned = coarseness(known.weights, known.covariances, len(poses), scan.ranges)
        self.extra_sd = apart
        believed = _believed(scan, apart)
        # Some models weigh rays that did not return; to the others, this scan says nothing.
        if not (returned or count_rays(self.sensor, poses, believed)):
            return
        log_likelihood = self.sensor.log_likelihood(poses, believed)
        slow, fast = settings.recovery_alpha_slow, settings.recovery_alpha_fast
        if slow and fast:
            rays = count_rays(self.sensor, poses, believed)
            self._recovery.observe(log_likelihood, weights, rays, slow, fast)
        weights = temper(log_likelihood, weights, self.likelihood_weight, self._least(weights))
        self._particles = Cloud(poses, weights)

    def _least(self, weights: Array) -> float:
        """Return the least effective sample size after this scan.

        All scans until the next resampling share the allowed loss. If each were allowed all of it,
        a few scans would leave one particle; if the first took all of it, the others would change
        nothing.
        """
        share, scans = self.parameters.min_effective, self.parameters.resample_interval
        least = len(weights) * math.pow(share, (self._scans % scans + 1) / scans)
        current = effective_sample_size(weights)
        # A given cloud may already have fewer effective particles; a scan must still count.
        return least if least < current else current * math.pow(share, 1 / scans)

    def _should_resample(self) -> bool:
        if self._scans % self.parameters.resample_interval:
            return False
        if not self.parameters.selective_resampling:
            return True
        return self.effective < 0.5 * len(self._particles.weights)

    def resample(self) -> Resampled:
        """Draw particles by weight, and spread their copies a little."""
        poses, weights = self._particles.poses, self._particles.weights
        scale = self.parameters.regularization
        kept = low_variance(weights, self._wanted(weights), self._rng)
        spread = regularize(poses, self._clusters, kept, scale, self._rng)
        renewed = np.zeros(len(spread), dtype=np.bool_)
        if share := self._recovery.share():
            renewed = self._rng.random(len(spread)) < share
            spread[renewed] = self.field.free_poses(self._rng, int(renewed.sum()))
            self._recovery = Recovery()  # as in nav2: a fall counts once
        self._particles = Cloud.even(spread)
        return Resampled(self._clusters, kept, renewed, in_order=scale == 0)

    def _wanted(self, weights: Array) -> int:
        """Return the number of particles to draw (KLD sampling).

        Table 8.4 draws particles one by one until there are enough for the cells that they fill.
        Here, ``max_particles`` are drawn at once, and the cells that they fill are counted. The
        result is a little larger, because a smaller draw would have missed some cells.
        """
        least, most = self._limits()
        if least == most:
            return most
        drawn = low_variance(weights, most, self._rng)
        occupied = count_cells(self._clusters.cells, drawn)
        wanted = kld_sample_size(occupied, self.parameters.pf_err, self.parameters.pf_z)
        return min(max(wanted, least), most)

    def _limits(self) -> tuple[int, int]:
        """Return the fewest and the most particles."""
        fewest = round(self.share * self.parameters.min_particles)
        return max(fewest, FEWEST), max(round(self.share * self.parameters.most_particles), FEWEST)

    def _describe(self) -> None:
        poses, weights = self._particles.poses, self._particles.weights
        turns = max(1, round(2 * math.pi / self.parameters.cell_theta))
        cells = Cells(self.parameters.cell_xy, turns)
        self._clusters: Clusters = find_clusters(poses, weights, cells)
        self._moved = False


def _believed(scan: Scan, extra_sd: float) -> Scan:
    """Return the scan with a larger spread; ``dataclasses.replace`` takes three times as long."""
    return Scan(
        scan.stamp,
        scan.bearings,
        scan.ranges,
        scan.robot_from_scan,
        scan.sight,
        extra_sd,
        scan.clear,
        scan.hidden,
    )
