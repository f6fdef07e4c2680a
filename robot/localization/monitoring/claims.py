"""What is claimed of an estimate: its state, and bounds that hold in 99.9 % of pictures."""

from __future__ import annotations

import math
from dataclasses import replace

from robot.geometry import Array, Pose2
from robot.localization.estimate import Hypothesis, Standing
from robot.localization.integrity import Integrity, State
from robot.localization.kernels.matrices import widest
from robot.localization.monitoring.monitor import Doubt

PLACE_QUANTILE, HEADING_QUANTILE = 3.72, 3.29
"""Standard deviations within which 99.9 % lie: of a place on a plane, and of a heading."""
LEAST_PLACE, LEAST_HEADING = 0.0005, 0.0015
"""Standard deviation of what no covariance knows: the scanner's own errors [m], [rad]."""
NARROW, NARROW_HEADING = 0.080, math.radians(10)
"""A wider bound is approximate only [m], [rad]."""
TURNED, WAY, TURN = 0.3, 0.03, 0.05
"""How odometry errs by itself, as standard deviations: a turn by way [rad/m], a way as a share of
it, and a turn as a share of it."""
ANYWHERE = 1.0
"""With a wider bound it is not known where the robot is [m]: a Gaussian alone may become so."""
CERTAIN = 0.95
"""Weight from which on one place is the only one."""
ANY = 0.5
"""Places that weigh less together are no answer: the robot may be anywhere."""


def claim(hypotheses: tuple[Hypothesis, ...], standing: Standing, doubt: Doubt) -> Integrity:
    """What may be claimed of the heaviest hypothesis.

    Args:
        hypotheses: heaviest first, with weights that sum to one, or less where it may be elsewhere.
        standing: what the filter knows of its search.
        doubt: what the monitor found.
    """
    if standing is Standing.LOST:
        return Integrity(State.LOST, alerts=doubt.alerts)
    if sum(hypothesis.weight for hypothesis in hypotheses) < ANY:
        return Integrity(State.SEARCHING, alerts=doubt.alerts)
    if hypotheses[0].weight <= CERTAIN:
        return Integrity(State.AMBIGUOUS, alerts=doubt.alerts)
    radius, heading = bounds(hypotheses[0].covariance + doubt.unknown)
    if radius > ANYWHERE:
        return Integrity(State.SEARCHING, alerts=doubt.alerts)
    if not doubt.fits or standing is not Standing.CONFIRMED:
        # It may be another place: no radius holds.
        return Integrity(State.APPROXIMATE, alerts=doubt.alerts)
    return Integrity(_one_place(radius, heading), radius, heading, doubt.alerts)


def carried_on(claimed: Integrity, moved: Pose2) -> Integrity:
    """What may be claimed after a step by odometry alone, as between two pictures."""
    if not math.isfinite(claimed.radius):
        return claimed
    way = math.hypot(moved.x, moved.y)
    turned = HEADING_QUANTILE * math.hypot(TURNED * way, TURN * moved.theta)
    heading = min(claimed.heading_bound + turned, math.pi)
    aside = way * math.sin(min(heading, math.pi / 2))
    radius = claimed.radius + aside + PLACE_QUANTILE * WAY * way
    return replace(claimed, state=_one_place(radius, heading), radius=radius, heading_bound=heading)


def _one_place(radius: float, heading: float) -> State:
    narrow = radius <= NARROW and heading <= NARROW_HEADING
    return State.CERTAIN if narrow else State.APPROXIMATE


def bounds(covariance: Array) -> tuple[float, float]:
    """Radius [m] and angle [rad] that hold in 99.9 % of pictures, by a covariance (3, 3)."""
    radius = PLACE_QUANTILE * math.hypot(widest(covariance), LEAST_PLACE)
    heading = HEADING_QUANTILE * math.sqrt(float(covariance[2, 2]) + LEAST_HEADING**2)
    return radius, min(heading, math.pi)
