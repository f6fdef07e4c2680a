"""A finer estimate: the scan laid on the edges at the pose that the filter found.

A cloud of some hundred particles has a mean that is off by the luck of its draws. Gauss-Newton
steps on the distances of the rays' ends from the edges take that away.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from robot.localization.estimate import Hypothesis
from robot.localization.kernels.matrices import inverse
from robot.localization.rays import rays_of
from robot.localization.scan_matching import ScanMatcher
from robot.localization.setup import Setup
from robot.scan import Scan

FEWEST_BEAMS = 100
"""Of a scan, if it has so many: rays cost little here, and each makes the pose finer."""
GATE = 10.0
"""Ranges that are off by so many standard deviations do not measure the edge."""
SLOPE = 25.0
"""Of the spread of a range with its square [1/m²]: one over the square of the camera's height."""
NEAR_SHARE = 0.1
"""Spread of a near range as a share of ``sigma_hit``, which has to cover a cloud's gaps."""
BELIEVED = 16.0
"""A pose errs so much less, as a variance, than the spread by which its rays are weighed beside the
cloud: that blend is the most exact, and this makes its covariance honest (NEES near 3)."""
WIDEST = 5.0
"""A hypothesis wider than so many standard deviations of a range is left as it is: its mean may
lie between two places."""
DRAWN = 4.0
"""Where scans say nothing, as along one edge, clouds grow narrower than they know: by chance in
drawing, and as scans err together. So many times wider is what their covariance is worth."""
LUCK = np.diag(np.square([1e-3, 1e-3, 3e-3]))
"""How far the filter's mean may be off besides its covariance [m², m², rad²]."""
INEXACT = np.diag(np.square([1e-4, 1e-4, 3e-4]))
"""Covariance that no number of rays takes away: a lens and a drawing are only so exact, and the
rays of one picture err together [m², m², rad²]."""


@dataclass(frozen=True, slots=True)
class Refinement:
    """Lays scans on edges at hypotheses that are already close."""

    matcher: ScanMatcher
    max_beams: int
    """Rays used of a scan."""
    believed: float = 1.0
    """How much more than the spread of its rays says a scan knows, as information."""

    @classmethod
    def of(cls, setup: Setup) -> Refinement | None:
        """As the parameters ask for; None if they do not."""
        sensor = setup.parameters.sensor
        if not setup.filter.refine:
            return None
        slope = 0.0 if setup.field.tape_width is None else SLOPE
        sd = sensor.sigma_hit * (NEAR_SHARE if slope else 1.0)
        gate = GATE * sensor.sigma_hit
        matcher = ScanMatcher(setup.field.edge_index, sensor.laser_max_range, sd, gate, slope)
        believed = BELIEVED if slope else 1.0
        return cls(matcher, max(sensor.max_beams, FEWEST_BEAMS), believed)

    def refine(self, hypothesis: Hypothesis, scan: Scan) -> Hypothesis:
        """The same hypothesis where the scan fits best, weighed with what was known of it."""
        if np.sqrt(np.diag(hypothesis.covariance)[:2].max()) > WIDEST * self.matcher.gate / GATE:
            return hypothesis
        known = inverse(hypothesis.covariance + LUCK)
        match = self.matcher.match(hypothesis.pose, rays_of(scan, self.max_beams), known)
        # Of the scan alone, and of the cloud what can be relied on.
        seen = self.believed * (match.information - known)
        return replace(
            hypothesis,
            pose=match.pose,
            covariance=inverse(seen + inverse(DRAWN * hypothesis.covariance + LUCK)) + INEXACT,
        )
