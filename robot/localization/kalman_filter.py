"""Extended Kalman filter on scans (Probabilistic Robotics, Tables 3.3 and 7.2)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from robot.fields.field import Field
from robot.geometry import (
    Array,
    Pose2,
    covariance_root,
    mean_pose,
    pose_covariance,
    wrap_angle,
)
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.filter import Cloud
from robot.localization.models.loosened_motion import loosened
from robot.localization.models.motion_models import MotionModel
from robot.localization.rays import rays_of
from robot.localization.scan_matching import ScanMatcher
from robot.localization.setup import Setup
from robot.scan import Scan

SHOWN = 200
"""Poses drawn from the belief, to be shown."""
WIDEST_GATE = 0.15
"""Farther off than this a range more likely measures another edge [m]."""
GATE = 10.0
"""Ranges that are off by so many standard deviations do not measure the edge."""
LEAST_VARIANCE = 1e-12
"""Nothing is known better than to a thousandth of a millimetre, and of a milliradian [m², rad²]."""


class KalmanFilter:
    """One Gaussian: quick and exact while it is about right, and lost for ever when it is not.

    A landmark is replaced by the edges that the rays meet; the update is iterated (Bell and Cathey
    1993), as a range changes with heading anything but linearly. Told a pose wrong by 70 mm and
    0.2 rad, it is right within a second in 33 of 40 drives, and with ``doubt`` 1 in 38; after
    twelve seconds in all.
    """

    def __init__(
        self,
        motion: MotionModel,
        matcher: ScanMatcher,
        field: Field,
        covariance: Array,
        max_beams: int,
        rng: np.random.Generator,
        *,
        doubt: float = 0.0,
    ) -> None:
        self.doubt = doubt
        """How much less ranges are believed while the pose is in doubt: 0 is the textbook's."""
        self.motion = motion
        self.looseness = 1.0
        """How many times more than the motion model says steps err."""
        self.matcher = matcher
        self.field = field
        self.max_beams = max_beams
        self._rng = rng
        # The same draws always, so that what is shown does not flicker.
        self._draws = _standard(rng.standard_normal((SHOWN, 3)))
        self.set_pose(field.start, covariance)

    @classmethod
    def of(cls, setup: Setup, rng: np.random.Generator) -> KalmanFilter:
        """With the models and parameters of a setup."""
        covariance, beams = setup.filter.initial_covariance, setup.parameters.sensor.max_beams
        matcher = matcher_of(setup)
        return cls(setup.motion, matcher, setup.field, covariance, beams, rng, doubt=1.0)

    @property
    def standing(self) -> Standing:
        """It does not look for other places."""
        return Standing.CONFIRMED

    def use(self, setup: Setup) -> None:
        """Go on with other models and parameters; the belief stays."""
        self.motion, self.matcher = setup.motion, matcher_of(setup)
        self.max_beams = setup.parameters.sensor.max_beams

    def loosen(self, factor: float) -> None:
        """From now on steps err so many times more than the motion model says."""
        self.looseness = factor

    @property
    def cloud(self) -> Cloud:
        """Draws from the belief, to be shown."""
        poses = self._pose.to_array() + self._draws @ covariance_root(self._covariance).T
        poses[:, 2] = wrap_angle(poses[:, 2])
        return Cloud.even(poses)

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """The only one."""
        return (Hypothesis(1.0, self._pose, self._covariance),)

    @property
    def effective(self) -> float:
        """Of the draws shown, those that the last scan left: by how much its ellipsoid shrank."""
        return SHOWN * self._left

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        """Start anew around a pose in the map, with covariance (3, 3) [m, m, rad]."""
        self._pose = pose
        self._covariance = _symmetric(covariance)
        self._left = 1.0

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Start anew from the mean and covariance of all places, which is none of them."""
        poses = np.array([each.pose.to_array() for each in hypotheses])
        weights = np.array([item.weight for item in hypotheses])
        mean = mean_pose(poses, weights / weights.sum())
        within = np.average(
            [hypothesis.covariance for hypothesis in hypotheses], axis=0, weights=weights
        )
        between = pose_covariance(poses, weights / weights.sum(), mean)
        self.set_pose(mean, within + between)

    def set_cloud(self, cloud: Cloud) -> None:
        """Start anew from the mean and covariance of given weighted poses."""
        mean = mean_pose(cloud.poses, cloud.weights)
        self.set_pose(mean, pose_covariance(cloud.poses, cloud.weights, mean))

    def scatter(self) -> None:
        """Start anew from the mean and covariance of all free poses: a poor picture of them."""
        self.set_cloud(Cloud.even(self.field.free_poses(self._rng, 2000)))

    def predict(self, moved: Pose2) -> None:
        """Follow a step by odometry."""
        step, noise = loosened(self.motion, self.looseness).moments(moved)
        self._pose, self._covariance = follow(self._pose, self._covariance, step, noise)

    def correct(self, scan: Scan) -> None:
        """Move to where prediction and scan agree best; the information of both adds up.

        A scan of which no ray fits says nothing.
        """
        # A pose told without any doubt has a covariance without an inverse.
        known = _inverse(self._covariance + LEAST_VARIANCE * np.eye(3))
        result = self._cautious(scan).match(self._pose, rays_of(scan, self.max_beams), known)
        self._left = 1.0
        if result.used:
            before, self._pose = self._covariance, result.pose
            self._covariance = _inverse(result.information)
            volumes = np.linalg.det([self._covariance, before])
            self._left = float(
                np.sqrt(np.clip(volumes[0] / max(volumes[1], 1e-30), SHOWN**-2, 1.0))
            )

    def _cautious(self, scan: Scan) -> ScanMatcher:
        """A matcher with a wider gate and a greater variance while the pose is in doubt.

        It lets in, within two standard deviations, the ranges that the right edges have from where
        the robot may be, and does not yet trust them: they may be of others.
        """
        if self.doubt == 0 or not scan.hit.any():
            return self.matcher
        reach = float(np.median(scan.ranges[scan.hit]))
        place = float(np.linalg.eigvalsh(self._covariance[:2, :2])[1])
        unsure = self.doubt * math.sqrt(max(place, 0.0) + reach**2 * self._covariance[2, 2])
        gate = max(self.matcher.gate, min(2 * unsure, WIDEST_GATE))
        return replace(self.matcher, sd=math.hypot(self.matcher.sd, unsure), gate=gate)


def matcher_of(setup: Setup) -> ScanMatcher:
    """Lays scans on edges, as exactly as the sensor's parameters say.

    Rays that err together count less: as if each were wider by the root of its share.
    """
    sensor = setup.parameters.sensor
    sd = sensor.sigma_hit / math.sqrt(sensor.likelihood_weight)
    return ScanMatcher(
        setup.field.edge_index, sensor.laser_max_range, sd, GATE * sd, sensor.sigma_slope
    )


def follow(pose: Pose2, covariance: Array, moved: Pose2, noise: Array) -> tuple[Pose2, Array]:
    """Carry a pose with its covariance over a step: G Sigma G^T + V M V^T.

    Args:
        pose: in the map, with covariance (3, 3) [m, m, rad].
        covariance: of the pose.
        moved: the step, seen from its start.
        noise: M (3, 3), the covariance of its end, seen from its start.
    """
    turned = Pose2(theta=pose.theta).apply(moved.to_array()[None, :2])[0]
    G = np.array([[1, 0, -turned[1]], [0, 1, turned[0]], [0, 0, 1]])
    c, s = np.cos(pose.theta), np.sin(pose.theta)
    V = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return pose @ moved, _symmetric(G @ covariance @ G.T + V @ noise @ V.T)


def _inverse(matrix: Array) -> Array:
    return _symmetric(np.linalg.inv(matrix).astype(np.float64))


def _symmetric(covariance: Array) -> Array:
    """Without what rounding has made of it."""
    even: Array = (covariance + covariance.T) / 2
    return even


def _standard(draws: Array) -> Array:
    """Draws (n, 3) with the mean and covariance that they are draws of: zero, and the unit."""
    centred = draws - draws.mean(axis=0)
    root = np.linalg.cholesky(centred.T @ centred / len(draws))
    standard: Array = np.linalg.solve(root, centred.T).T
    return standard
