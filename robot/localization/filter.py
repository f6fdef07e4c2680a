"""What any filter offers: a belief about the pose that follows odometry and scans."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from robot.geometry import Array, Pose2, compose, covariance_root
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.setup import Setup
from robot.scan import Scan


@dataclass(frozen=True, slots=True)
class Cloud:
    """Weighted poses that stand for a belief: what is shown of any filter."""

    poses: Array = field(repr=False)
    """(n, 3) [m, m, rad] in the map."""
    weights: Array = field(repr=False)
    """(n,), summing to one."""

    @classmethod
    def even(cls, poses: Array) -> Cloud:
        """Poses that all weigh the same."""
        return cls(poses, np.full(len(poses), 1.0 / len(poses)))

    @classmethod
    def joined(cls, clouds: Sequence[Cloud], weights: Array) -> Cloud:
        """Several clouds in one, weighed relative to each other by weights (n,)."""
        shares = (weights / weights.sum()).tolist()
        parts = [cloud.weights * share for cloud, share in zip(clouds, shares, strict=True)]
        return cls(np.concatenate([cloud.poses for cloud in clouds]), np.concatenate(parts))

    @classmethod
    def drawn(
        cls, hypotheses: tuple[Hypothesis, ...], count: int, rng: np.random.Generator
    ) -> Cloud:
        """About so many poses drawn from hypotheses: by weight from each, and at least one."""
        total = sum(hypothesis.weight for hypothesis in hypotheses)
        parts = []
        for item in hypotheses:
            share = max(1, round(count * item.weight / total))
            noise = rng.standard_normal((share, 3)) @ covariance_root(item.covariance).T
            parts.append(compose(item.pose.to_array() + noise, np.zeros(3)))
        return cls.even(np.concatenate(parts))


class Filter(Protocol):
    """A Bayes filter (Probabilistic Robotics, Table 2.1): predict with motion, correct by scans.

    When to do so is decided elsewhere (``Localizer``).
    """

    @property
    def cloud(self) -> Cloud:
        """The belief after the last scan or start, before any resampling."""
        ...

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """Where the robot may be, heaviest first; none while nothing can be said."""
        ...

    @property
    def effective(self) -> float:
        """How many equally heavy particles the cloud is worth."""
        ...

    @property
    def standing(self) -> Standing:
        """What it knows of its search for other places."""
        ...

    def use(self, setup: Setup) -> None:
        """Go on with other models and parameters; the belief stays."""
        ...

    def loosen(self, factor: float) -> None:
        """From now on steps err so many times more than the motion model says."""
        ...

    def set_pose(self, pose: Pose2, covariance: Array) -> None:
        """Start anew around a pose in the map, with covariance (3, 3) [m, m, rad]."""
        ...

    def set_hypotheses(self, hypotheses: tuple[Hypothesis, ...]) -> None:
        """Start anew at places whose weights are relative to each other."""
        ...

    def set_cloud(self, cloud: Cloud) -> None:
        """Start anew from given weighted poses."""
        ...

    def scatter(self) -> None:
        """Start anew: the robot may be anywhere on the field."""
        ...

    def predict(self, moved: Pose2) -> None:
        """Follow a step by odometry, seen from its start."""
        ...

    def correct(self, scan: Scan) -> None:
        """Weigh the belief by a scan."""
        ...
