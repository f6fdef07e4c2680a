"""Claims about an estimate: its state, and bounds that hold in 99.9 % of pictures.

What half and twice of a constant change is said as ``python -m benchmarks.constants --few`` found
it: of pictures 40.7 % are certain and 0.7 % misleading.
"""

from __future__ import annotations

import math
from dataclasses import replace

from robot.covariance import widest
from robot.geometry import Array, Pose2
from robot.localization.estimate import ONLY_PLACE, Hypothesis, Integrity, Standing, State
from robot.localization.monitoring.doubt import Doubt

PLACE_QUANTILE, HEADING_QUANTILE = 3.72, 3.29
"""Standard deviations that contain 99.9 %: of a position on a plane, and of a heading."""
LEAST_PLACE, LEAST_HEADING = 0.0005, 0.0015
"""Standard deviations of the scanner's own errors, which no covariance includes [m], [rad]. Half
and twice: as many are certain, and misleading."""
NARROW, NARROW_HEADING = 0.080, math.radians(10)
"""With a wider bound, an estimate is only approximate [m], [rad]. What *certain* means
(docs/integrity.md). Half of the radius: 39.4 % certain, none misleading; twice: nothing changes.
Half of the heading: 39.5 and 0.3 %; twice: 41.2 and 0.7."""
TURNED, WAY, TURN = 0.3, 0.03, 0.05
"""Standard deviations of odometry: of the turn by distance [rad/m], of a distance as a share of it,
and of a turn as a share of it. They widen bounds between two pictures, so that no claim at a
picture depends on them."""
MAX_RADIUS = 1.0
"""With a wider bound, the robot's place is unknown [m]: a single Gaussian may become so wide. Half
and twice: no claim changes."""
ANY = 0.5
"""If all places together weigh less, the robot may be anywhere. Half: no claim changes; twice,
nothing is ever certain."""


def claim(hypotheses: tuple[Hypothesis, ...], standing: Standing, doubt: Doubt) -> Integrity:
    """Return what may be claimed about the heaviest hypothesis.

    Args:
        hypotheses: heaviest first; weights sum to one, or to less if the robot may be elsewhere.
        standing: the state of the filter's search.
        doubt: what the monitor found.
    """
    if standing is Standing.LOST:
        return Integrity(State.LOST, alerts=doubt.alerts)
    if sum(hypothesis.weight for hypothesis in hypotheses) < ANY:
        return Integrity(State.SEARCHING, alerts=doubt.alerts)
    if hypotheses[0].weight <= ONLY_PLACE:
        return Integrity(State.AMBIGUOUS, alerts=doubt.alerts)
    radius, heading = bounds(hypotheses[0].covariance + doubt.unknown)
    if radius > MAX_RADIUS:
        return Integrity(State.SEARCHING, alerts=doubt.alerts)
    if not doubt.fits or standing is Standing.UNCONFIRMED:
        # The robot may be at another place, so no bound holds.
        return Integrity(State.APPROXIMATE, alerts=doubt.alerts)
    claimed = State.GIVEN if standing is Standing.GIVEN else State.CERTAIN
    return Integrity(_one_place(claimed, radius, heading), radius, heading, doubt.alerts)


def propagate_claim(claimed: Integrity, moved: Pose2) -> Integrity:
    """Return what may be claimed after a step by odometry alone, as between two pictures."""
    if not math.isfinite(claimed.radius):
        return claimed
    way = math.hypot(moved.x, moved.y)
    turned = HEADING_QUANTILE * math.hypot(TURNED * way, TURN * moved.theta)
    heading = min(claimed.heading_bound + turned, math.pi)
    aside = way * math.sin(min(heading, math.pi / 2))
    radius = claimed.radius + aside + PLACE_QUANTILE * WAY * way
    state = _one_place(claimed.state, radius, heading)
    return replace(claimed, state=state, radius=radius, heading_bound=heading)


def _one_place(narrowly: State, radius: float, heading: float) -> State:
    """Return the state of a narrow bound, as long as the bound is narrow."""
    narrow = radius <= NARROW and heading <= NARROW_HEADING
    return narrowly if narrow else State.APPROXIMATE


def bounds(covariance: Array) -> tuple[float, float]:
    """Return radius [m] and angle [rad] that hold in 99.9 % of pictures, by a covariance (3, 3)."""
    radius = PLACE_QUANTILE * math.hypot(widest(covariance), LEAST_PLACE)
    heading = HEADING_QUANTILE * math.sqrt(float(covariance[2, 2]) + LEAST_HEADING**2)
    return radius, min(heading, math.pi)
