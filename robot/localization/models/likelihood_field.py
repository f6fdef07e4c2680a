"""Likelihood field: a scan fits a pose if its ends lie on edges of the map."""

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
"""An edge is ignored where it contributes less than exp(-6) of the likelihood of a false range."""


@dataclass(frozen=True)
class LikelihoodField:
    """Likelihood field for range finders (Probabilistic Robotics, Table 6.3), by direction.

    p = z_hit exp(-d^2 / 2 sigma_hit^2) + z_rand / range_max for each ray that returned, where d is
    the distance of its end from the nearest edge that the ray can meet. Rays without a return do
    not count.
    """

    field: EntryField
    sigma_hit: float
    """Standard deviation of a range [m]."""
    z_hit: float
    z_rand: float
    range_max: float
    """[m]"""
    max_beams: int
    """Most rays used; they are spread evenly over those that returned."""
    sigma_slope: float = 0.0
    """Growth of sigma_hit with the range r, by the factor 1 + slope r^2 [1/m²]."""

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Return the log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
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
        """Return how many rays the log-likelihood is the sum of: at most ``max_beams``."""
        return min(int(np.count_nonzero(scan.hit)), self.max_beams)

    def counted(self, scan: Scan) -> NDArray[np.intp]:
        """Return the indices of the rays that the log-likelihood is the sum of."""
        hits = np.flatnonzero(scan.hit)
        return hits[evenly(len(hits), self.max_beams)]

    @cached_property
    def _curve(self) -> tuple[float, NDArray[np.float32]]:
        """Return ``end``, and log p as a polynomial of 2 x / end - 1, with x = d^2 / 2 sigma^2.

        The polynomial is accurate to 1e-3 up to the end; beyond it, log p hardly changes.
        """
        end = max(self._log_p(0.0) - self._log_p(math.inf), 0.0) + FADED
        log_p = np.vectorize(self._log_p)
        fit = Chebyshev.interpolate(lambda t: log_p((t + 1) * end / 2), DEGREE)
        return end, fit.convert(kind=Polynomial).coef.astype(np.float32)

    def _log_p(self, x: float) -> float:
        """Return log p of a ray, by x = d^2 / 2 sigma^2."""
        false = max(self.z_rand / self.range_max, 1e-30)
        return math.log(self.z_hit * math.exp(-x) + false)
