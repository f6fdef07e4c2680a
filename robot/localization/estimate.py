"""What the filter believes: hypotheses with weights, the heaviest of which is the estimate."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto

from robot.geometry import Array, Pose2


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One place where the robot may be: a cluster of particles or boxes, or a Gaussian."""

    weight: float
    """Probability, 0 to 1. Those of an estimate sum to one, or to less: the rest is elsewhere."""
    pose: Pose2
    """Weighted mean in the map."""
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""


class Standing(Enum):
    """What a filter knows of its search for other places."""

    CONFIRMED = auto()
    """Where it was told, or it has looked over the whole field since it was lost."""
    UNCONFIRMED = auto()
    """It was lost, and has not yet looked for all places again."""
    LOST = auto()
    """The robot is likelier elsewhere than at all the places that are followed."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """The filter's answer to one scan."""

    stamp: float
    """Of the scan [s]."""
    hypotheses: tuple[Hypothesis, ...]
    """Heaviest first; at least one."""
    effective: float
    """Effective sample size, before resampling."""

    @property
    def pose(self) -> Pose2:
        """Pose of the heaviest hypothesis."""
        return self.hypotheses[0].pose

    @property
    def covariance(self) -> Array:
        """Covariance (3, 3) [m, m, rad] of the heaviest hypothesis."""
        return self.hypotheses[0].covariance
