"""The filter's belief: weighted hypotheses. The heaviest one is the estimate."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto

from robot.geometry import Array, Pose2


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One place where the robot may be: a cluster of particles or boxes, or a Gaussian."""

    weight: float
    """Probability, 0 to 1.

    The weights of an estimate sum to at most one. The rest is the probability of being elsewhere.
    """
    pose: Pose2
    """Weighted mean in the map."""
    covariance: Array = field(repr=False)
    """(3, 3) [m, m, rad]"""


class Standing(Enum):
    """State of a filter's search for other places."""

    CONFIRMED = auto()
    """The place was not doubted since the start, or a search of the whole field confirmed it."""
    UNCONFIRMED = auto()
    """The place was doubted, and no search of the whole field has confirmed it since."""
    LOST = auto()
    """The robot is more likely elsewhere than at any of the followed places."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """The filter's answer to one scan."""

    stamp: float
    """The scan's stamp [s]."""
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
