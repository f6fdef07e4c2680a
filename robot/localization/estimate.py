"""The filter's belief, weighted hypotheses, and its integrity: what is claimed of the estimate.

*Integrity* is a term of aviation. Information is misleading if it is claimed to be certain and the
truth lies outside the claimed bound. No information is better than misleading information.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import Enum, StrEnum, auto

from robot.geometry import Array, Pose2

ONLY_PLACE = 0.95
"""Weight above which a hypothesis counts as the only place. What is claimed, what a search confirms
and what may be learnt at a place go by the same weight, or they would contradict one another. With
0.9, claims are misleading in 0.8 % of pictures instead of 0.7; with 0.975 in as many (``--few`` of
``python -m benchmarks.constants``)."""


class State(StrEnum):
    """How far the estimate can be relied on."""

    CERTAIN = "certain"
    """One place, and the bound is narrow."""
    GIVEN = "given"
    """As somebody gave it, with a narrow bound if that is true; no search has confirmed it yet."""
    APPROXIMATE = "approximate"
    """One place with a wide bound, or without one while the place is in doubt."""
    AMBIGUOUS = "ambiguous"
    """Several places look alike."""
    SEARCHING = "searching"
    """No place stands out, or its bound is wider than a metre."""
    LOST = "lost"
    """The known place does not fit any more."""


BOUNDED = (State.CERTAIN, State.GIVEN)
"""States in which a narrow bound is told: it holds, or does so if what was given is true."""
KNOWN = (*BOUNDED, State.APPROXIMATE)
"""States in which the filter holds one place for the robot's."""


class Cause(StrEnum):
    """What may be wrong when scans and odometry disagree with the models."""

    CAMERA_ASKEW = "camera askew"
    PICTURES_LATE = "pictures late"
    WHEEL_SLIP = "wheel slip"
    WHEEL_SIZE = "wheel size"
    MAP = "map"
    MODEL = "model"
    MOTORS = "motors"
    FROZEN = "picture frozen"


@dataclass(frozen=True, slots=True)
class Alert:
    """A reason for doubt."""

    cause: Cause
    text: str
    """The cause in plain words, with its size if that is known."""


@dataclass(frozen=True, slots=True)
class Integrity:
    """What the filter claims about an estimate."""

    state: State
    radius: float = math.inf
    """The true position lies within this distance of the estimate [m], in 99.9 % of pictures."""
    heading_bound: float = math.pi
    """The true heading lies within this angle of the estimate's [rad], in 99.9 % of pictures."""
    alerts: tuple[Alert, ...] = ()
    """The most recent reason for doubt first."""

    def because_of(self, alerts: tuple[Alert, ...]) -> Integrity:
        """Return it with other alerts; nothing is claimed while motors are plugged in wrongly."""
        if self.state in BOUNDED and any(alert.cause is Cause.MOTORS for alert in alerts):
            return Integrity(State.APPROXIMATE, alerts=alerts)
        return replace(self, alerts=alerts)


SEARCHING = Integrity(State.SEARCHING)
"""The claim while nothing is known."""


@dataclass(frozen=True, slots=True, eq=False)
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
    """A search of the whole field has confirmed the place, or the filter makes none."""
    GIVEN = auto()
    """The place is as somebody gave it, and neither doubted nor confirmed since."""
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


@dataclass(frozen=True, slots=True)
class Belief:
    """The filter's estimate, with the odometry at its stamp."""

    estimate: Estimate
    odom_from_robot: Pose2
    """Odometry at the estimate's stamp."""

    def pose(self, odom_from_robot: Pose2) -> Pose2:
        """Return the estimated pose, carried forward to a later odometry pose."""
        return self.estimate.pose @ self.moved(odom_from_robot)

    def moved(self, odom_from_robot: Pose2) -> Pose2:
        """Return the robot's motion from the estimate's stamp to a later odometry pose."""
        return self.odom_from_robot.inverse() @ odom_from_robot
