"""Refines an estimate: lays the scan on the edges, starting from the filter's pose.

The mean of some hundred particles has a random error, because the particles are drawn. Gauss-Newton
steps on the distances between the rays' ends and the edges remove that error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from robot.covariance import inverse
from robot.localization.estimate import Hypothesis
from robot.localization.filter import Setup
from robot.localization.scan_matching import GATE_SDS, SLOPE, ScanMatcher
from robot.scan import Scan, rays_of

FEWEST_BEAMS = 100
"""At least this many rays of a scan are used, if it has them: they cost little here, and each one
improves the pose."""
NEAR_SHARE = 0.1
"""Spread of a near range as a share of ``sigma_hit``, which also covers the gaps in a cloud."""
BELIEVED = 16.0
"""Factor by which the pose's variance is smaller than the spread of its rays says. That spread
weighs the rays against the cloud, and gives the most exact pose; this factor then makes the
covariance honest. Half and twice: nothing changes beyond chance (``--few``)."""
WIDEST = 5.0
"""A hypothesis wider than this many standard deviations of a range is not refined: its mean may lie
between two places."""
DRAWN = 1.4
"""Factor on the covariance of a cloud. Where scans say nothing, as along a single edge, clouds grow
too narrow: by chance in resampling, and because the errors of scans are correlated. Half and twice:
nothing changes beyond chance (``--few``)."""
MEAN_ERROR = np.diag(np.square([1e-3, 1e-3, 3e-3]))
"""Error of the filter's mean that its covariance does not include [m², m², rad²]."""
INEXACT = np.diag(np.square([1e-4, 1e-4, 3e-4]))
"""Covariance that remains with any number of rays: a lens and a drawing have limited accuracy, and
the errors of the rays of one picture are correlated [m², m², rad²]."""


@dataclass(frozen=True, slots=True)
class Refinement:
    """Lays scans on edges, starting from hypotheses that are already close."""

    matcher: ScanMatcher
    max_beams: int
    """Most rays used of a scan."""
    believed: float = 1.0
    """Factor on the information that a scan gives by the spread of its rays."""

    @classmethod
    def of(cls, setup: Setup) -> Refinement | None:
        """Return the refinement for a setup's parameters; None if they turn it off."""
        sensor = setup.parameters.sensor
        if not setup.filter.refine:
            return None
        slope = SLOPE if setup.field.tape else 0.0
        sd = sensor.sigma_hit * (NEAR_SHARE if slope else 1.0)
        gate = GATE_SDS * sensor.sigma_hit
        matcher = ScanMatcher(setup.field.edge_index, sensor.laser_max_range, sd, gate, slope)
        believed = BELIEVED if slope else 1.0
        return cls(matcher, max(sensor.max_beams, FEWEST_BEAMS), believed)

    def refine(self, hypothesis: Hypothesis, scan: Scan) -> Hypothesis:
        """Return the hypothesis at the pose that fits both the scan and its prior best."""
        widest = math.sqrt(max(hypothesis.covariance[0, 0], hypothesis.covariance[1, 1]))
        if widest > WIDEST * self.matcher.gate / GATE_SDS:
            return hypothesis
        known = inverse(hypothesis.covariance + MEAN_ERROR)
        match = self.matcher.match(hypothesis.pose, rays_of(scan, self.max_beams), known)
        # The pose lies between the cloud's and the scan's as their weights here say, so it has its
        # share of the error of each, which are larger and smaller than these weights.
        seen = (match.information - known) / self.believed
        drawn = known @ (DRAWN * hypothesis.covariance + MEAN_ERROR) @ known
        gain = inverse(match.information)
        covariance = gain @ (seen + drawn) @ gain + INEXACT
        return replace(hypothesis, pose=match.pose, covariance=covariance)
