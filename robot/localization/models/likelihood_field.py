"""Likelihood field: a scan fits a pose when its ends lie on edges of the map."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.kernels.ray_sums import DEGREE, sum_over_rays
from robot.localization.models.entry_field import EntryField
from robot.scan import Scan, evenly

FADED = 6.0
"""Where an edge makes a return likelier by no more than exp(-6), it is as good as none."""


@dataclass(frozen=True)
class LikelihoodField:
    """Likelihood field for range finders (Probabilistic Robotics, Table 6.3), by direction.

    p = z_hit exp(-d^2 / 2 sigma_hit^2) + z_rand / range_max for each ray that returned, with d the
    distance of its end from the nearest edge that it can meet. Rays without a return say nothing.
    """

    field: EntryField
    sigma_hit: float
    """Standard deviation of a range [m]."""
    z_hit: float
    z_rand: float
    range_max: float
    """[m]"""
    max_beams: int
    """Rays used of a scan, evenly spread over those that returned."""
    sigma_slope: float = 0.0
    """How sigma_hit grows with a range r, as 1 + slope r^2 [1/m²]."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        field, start = self.field, scan.robot_from_scan
        end, curve = self._curve
        return sum_over_rays(
            poses,
            scan.bearings,
            scan.ranges,
            (start.x, start.y, start.theta),
            self.max_beams,
            field.planes,
            field.origin,
            field.resolution,
            field.max_distance,
            (self.sigma_hit, self.sigma_slope, scan.extra_sd),
            end,
            curve,
        )

    def count_rays(self, poses: Array, scan: Scan) -> int:
        """How many rays the log-likelihood is the sum of: of those that returned, all it may."""
        return min(int(np.count_nonzero(scan.hit)), self.max_beams)

    def counted(self, scan: Scan) -> NDArray[np.intp]:
        """Indices of the rays that the log-likelihood is the sum of."""
        hits = np.flatnonzero(scan.hit)
        return hits[evenly(len(hits), self.max_beams)]

    @cached_property
    def _curve(self) -> tuple[float, NDArray[np.float32]]:
        """Log p by x = d^2 / 2 sigma^2, as a polynomial of 2 x / end - 1; and that end.

        Beyond the end log p hardly changes; up to it the polynomial is right to 1e-3.
        """
        end = max(self._log_p(0.0) - self._log_p(math.inf), 0.0) + FADED
        log_p = np.vectorize(self._log_p)
        fit = Chebyshev.interpolate(lambda t: log_p((t + 1) * end / 2), DEGREE)
        return end, fit.convert(kind=Polynomial).coef.astype(np.float32)

    def _log_p(self, x: float) -> float:
        """Of a ray that ends off an edge, by x = d^2 / 2 sigma^2."""
        false = max(self.z_rand / self.range_max, 1e-30)
        return math.log(self.z_hit * math.exp(-x) + false)
