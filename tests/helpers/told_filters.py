"""Filters that write down what they are told."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import square_drive
from square_drive import ON_STUB

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.filter import Cloud, Setup
from robot.localization.hypotheses.multi_hypothesis import MultiHypothesisFilter
from robot.localization.hypotheses.track import Track
from robot.scan import Scan

NARROW = np.diag(np.square([0.001, 0.001, 0.005]))


class Notes:
    """What any of them writes down."""

    told: list[object]

    standing = Standing.CONFIRMED

    def loosen(self, factor: float) -> None:
        self.told.append(factor)

    def search_anew(self) -> None:
        self.told.append("search anew")

    def use(self, setup: Setup) -> None:
        self.told.append(setup)

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        self.told.append((pose, covariance.tolist()))

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        self.told.append(hypotheses)

    def set_cloud(self, cloud: Cloud) -> None:
        self.told.append(cloud)

    def scatter(self) -> None:
        self.told.append("scatter")

    def predict(self, moved: Pose2) -> None:
        self.told.append(moved)

    def correct(self, scan: Scan) -> None:
        self.told.append(scan)


@dataclass
class Told(Notes):
    """A filter that does nothing else."""

    hypotheses: tuple[Hypothesis, ...] = (
        Hypothesis(0.6, Pose2(0.003, 0, 0.01), NARROW),
        Hypothesis(0.4, Pose2(0.003, 0.002, 0.02), NARROW),
    )
    effective: float = 33.0
    told: list[object] = field(default_factory=list)
    cloud: Cloud = field(default_factory=lambda: Cloud.even(np.zeros((1, 3))))


@dataclass
class Fixed(Notes):
    """A filter of one place that follows odometry."""

    pose: Pose2
    weights: tuple[float, ...] = (1.0,)
    share: float = 1.0
    told: list[object] = field(default_factory=list)
    effective: float = 4.0

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        return tuple(
            Hypothesis(weight, self.pose @ Pose2(0.1 * i), square_drive.NARROW)
            for i, weight in enumerate(self.weights)
        )

    @property
    def cloud(self) -> Cloud:
        return Cloud.even(np.tile(self.pose.to_array(), (4, 1)))

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        self.pose = pose

    def predict(self, moved: Pose2) -> None:
        self.pose = self.pose @ moved


def at_places(*places: tuple[Pose2, float], setup: Setup = ON_STUB) -> MultiHypothesisFilter:
    """Follows given places with given log-weights."""
    f = MultiHypothesisFilter(setup, lambda *_: Fixed(Pose2()), np.random.default_rng(0))
    f.set_pose(Pose2(), square_drive.NARROW)
    f._tracks = [Track(Fixed(pose), weight) for pose, weight in places]
    return f
