"""Grid localization: the discrete Bayes filter (Probabilistic Robotics, Tables 4.1 and 8.1)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robot.fields.field import Field
from robot.geometry import Array, Pose2, compose, mean_pose, pose_covariance
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.filter import Cloud, Setup
from robot.localization.grid.grid_motion import moved_grid
from robot.localization.grid.pose_grid import Boxes, PoseGrid, cloud_grid, even_grid, normal_grid
from robot.localization.models.motion_models import MotionModel, follow, loosened
from robot.localization.models.sensor_models import SensorModel, count_rays
from robot.localization.particles.clusters import Cells, find_clusters
from robot.localization.particles.resampling import effective_sample_size, low_variance
from robot.scan import Scan

SHOWN = 4000
"""Most boxes that are displayed."""
LEAST = 1e-4
"""A box with less than this share of the heaviest box's probability is dropped."""
LEAST_CLUSTERED = 0.01
"""Boxes below this share of the heaviest do not join two hypotheses."""
RANDOM_PLACES = 200_000
"""Random places on the field, by which the free share of each box is estimated."""
MOVED = 0.25
"""Share of the affordable boxes that may be moved, because moving takes longer than weighing."""


class GridFilter:
    """Keeps the probability of each box of poses that is not negligible.

    A box is weighed as a pose in its middle, with ranges blurred by its size. The boxes are as
    small as can be afforded: they are coarse while there are many, and are cut into eight when few
    are left. So the filter can start all over the field, and its error is still a fraction of the
    finest box: 0.66 mm (root mean square) on the simulated robot (``brickpose bench accuracy``). A
    dropped box never comes back: a robot that was carried off is lost until the filter is
    scattered.
    """

    def __init__(
        self,
        motion: MotionModel,
        sensor: SensorModel,
        field: Field,
        covariance: Array,
        *,
        likelihood_weight: float = 1.0,
        finest_xy: float = 0.00125,
        finest_theta: float = math.radians(0.35),
        most_cells: int = 20_000,
    ) -> None:
        """Start around the field's start.

        Args:
            motion: how a step by odometry errs; only its covariance is used.
            sensor: how well a scan fits a pose.
            field: where the robot may be.
            covariance: (3, 3) [m, m, rad] of the start.
            likelihood_weight: share of the log-likelihood that counts.
            finest_xy: side of the finest boxes [m].
            finest_theta: their width in heading [rad]; a full turn has a power of two of them.
            most_cells: most boxes that are weighed by a scan.
        """
        self.motion = motion
        self.looseness = 1.0
        """Factor on the motion model's standard deviations."""
        self.sensor = sensor
        self.field = field
        self.likelihood_weight = likelihood_weight
        self.most_cells = most_cells
        self.finest = Boxes(finest_xy, 2 ** max(3, round(math.log2(2 * math.pi / finest_theta))))
        self._found: tuple[Hypothesis, ...] | None = None
        self._grid: PoseGrid
        self._moved: Pose2
        """The steps since the boxes were last moved."""
        self._noise: Array
        """Covariance (3, 3) of the end of these steps."""
        self.set_pose(field.start, covariance)

    @classmethod
    def of(cls, setup: Setup, _rng: np.random.Generator) -> GridFilter:
        """Return a filter with the models and parameters of a setup; it draws nothing."""
        return cls(
            setup.motion,
            setup.sensor,
            setup.field,
            setup.filter.initial_covariance,
            likelihood_weight=setup.likelihood_weight,
        )

    @property
    def standing(self) -> Standing:
        """Always confirmed: it makes no search; one beside it judges its place (SearchBeside)."""
        return Standing.CONFIRMED

    def search_anew(self) -> None:
        """Change nothing, because this filter does not search for other places."""

    def use(self, setup: Setup) -> None:
        """Switch to other models and parameters, and keep the belief."""
        self.motion, self.sensor = setup.motion, setup.sensor
        self.likelihood_weight = setup.likelihood_weight

    def loosen(self, factor: float) -> None:
        """Multiply the motion model's standard deviations by a factor from now on."""
        self.looseness = factor

    @property
    def cloud(self) -> Cloud:
        """The middles of the boxes with their probabilities; a sample if there are too many."""
        poses = compose(self._grid.poses, self._moved.to_array())
        if len(poses) <= SHOWN:
            return Cloud(poses, self._grid.mass)
        # The draws are always the same, so that the display does not flicker.
        drawn = low_variance(self._grid.mass, SHOWN, np.random.default_rng(0))
        return Cloud.even(poses[drawn])

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """Groups of boxes that touch, heaviest first."""
        if self._found is None:
            self._found = self._find()
        return self._found

    @property
    def extra_sd(self) -> float:
        """Always zero: ranges are blurred by the size of the boxes instead."""
        return 0.0

    @property
    def effective(self) -> float:
        """Effective number of boxes (1 / sum of squared probabilities)."""
        return effective_sample_size(self._grid.mass)

    @property
    def cell(self) -> Array:
        """Current sides (3,) of a box [m, m, rad]."""
        return self._grid.boxes.size

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        """Restart around a pose in the map, with covariance (3, 3) [m, m, rad]."""
        self._restart(normal_grid(self.finest, pose, covariance, self.most_cells))

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Restart at hypotheses; only the ratios of their weights count."""
        self.set_cloud(Cloud.drawn(hypotheses, RANDOM_PLACES, np.random.default_rng(0)))

    def set_cloud(self, cloud: Cloud) -> None:
        """Restart from given weighted poses."""
        self._restart(cloud_grid(self.finest, cloud))

    def scatter(self) -> None:
        """Restart evenly over the free field."""
        free = self.field.free_poses(np.random.default_rng(0), RANDOM_PLACES)
        self._restart(even_grid(self.finest, free[:, :2], self.most_cells))

    def predict(self, moved: Pose2) -> None:
        """Follow a step by odometry.

        Steps are collected until they err by half a box. Until then, the boxes hold poses at the
        start of these steps, and rounding loses nothing.
        """
        step, noise = loosened(self.motion, self.looseness).moments(moved)
        self._moved, self._noise = follow(self._moved, self._noise, step, noise)
        self._found = None
        xy, _, theta = size = self._grid.boxes.size
        errs = (np.diag(self._noise) >= np.square(size / 2)).any()
        # Poses of one box drift apart by their headings.
        parted = math.hypot(self._moved.x, self._moved.y) * theta >= xy / 2
        if errs or parted:
            self._move()

    def correct(self, scan: Scan) -> None:
        """Weigh the boxes by a scan, and cut them while there are few enough."""
        self._found = None
        before = self._grid
        # Some models weigh rays that did not return; to the others, this scan says nothing.
        if not (scan.hit.any() or count_rays(self.sensor, before.poses, scan)):
            return
        while True:
            after = self._weighed(before, scan)
            matter = after.mass > LEAST * after.mass.max()
            if before.boxes.level == 0 or 8 * np.count_nonzero(matter) > self.most_cells:
                break
            # The belief before the scan is cut and weighed again, so that a scan counts once.
            before = before.only(matter).finer()
        self._grid = after.only(matter)

    def _move(self) -> None:
        grid = moved_grid(self._grid, self._moved, self._noise)
        grid = grid.only(grid.mass > LEAST * grid.mass.max())
        while len(grid.mass) > MOVED * self.most_cells:
            grid = grid.coarser()
        self._restart(grid)

    def _restart(self, grid: PoseGrid) -> None:
        """Begin with other boxes, at the robot's current pose: no step is collected yet."""
        self._grid = grid
        self._moved, self._noise = Pose2(), np.zeros((3, 3))
        self._found = None

    def _weighed(self, grid: PoseGrid, scan: Scan) -> PoseGrid:
        xy, _, theta = grid.boxes.size / math.sqrt(12)
        returned = scan.ranges[scan.hit]
        blur = math.hypot(xy, theta * float(np.median(returned))) if len(returned) else xy
        poses = compose(grid.poses, self._moved.to_array())
        log_likelihood = self.sensor.log_likelihood(poses, replace(scan, extra_sd=blur))
        gain = self.likelihood_weight * (log_likelihood - log_likelihood.max())
        mass = grid.mass * np.exp(gain)
        return replace(grid, mass=mass / mass.sum())

    def _find(self) -> tuple[Hypothesis, ...]:
        grid = self._grid.only(self._grid.mass > LEAST_CLUSTERED * self._grid.mass.max())
        poses, size = grid.poses, grid.boxes.size
        clusters = find_clusters(poses, grid.mass, Cells(float(size[0]), grid.boxes.turns))
        return tuple(
            self._describe(poses[mine], grid.mass[mine])
            for mine in (clusters.labels == place for place in range(len(clusters.hypotheses)))
        )

    def _describe(self, poses: Array, mass: Array) -> Hypothesis:
        mean = mean_pose(poses, mass)
        # All poses within a box are equally likely.
        within = np.diag(np.square(self._grid.boxes.size) / 12)
        covariance = pose_covariance(poses, mass, mean) + within
        pose, covariance = follow(mean, covariance, self._moved, self._noise)
        return Hypothesis(float(mass.sum()), pose, covariance)
