"""Beam model: a scan fits a pose when its rays, cast there, are as long."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.fields.edge_index import EdgeIndex
from robot.geometry import Array, heading_vectors
from robot.localization.kernels.beam_sums import beam_log_likelihoods
from robot.scan import Scan, evenly

NEAR, FAR = 0.02, 0.08
"""An edge so close to where a ray's sight begins, or ends, may be missed [m]: tape must be seen
whole, and its far edge is 50 mm behind, more for a ray that meets it aslant."""


@dataclass(frozen=True)
class Beam:
    """Beam range finder model (Probabilistic Robotics, Table 6.1), rays cast at the exact edges.

    p = z_hit N(z; z*, sigma_hit) + z_short lambda_short exp(-lambda_short z) [z <= z*] +
    z_max [no return] + z_rand / range_max. Unlike the field it knows that an edge hides what lies
    behind it, and that a ray that should have returned did not: that is z_max against one where
    no edge is in sight.
    """

    edges: EdgeIndex = field(repr=False)
    """Of the field."""
    sigma_hit: float
    """[m]"""
    z_hit: float
    z_short: float
    z_max: float
    z_rand: float
    lambda_short: float
    """[1/m]"""
    range_max: float
    """[m]"""
    max_beams: int

    def log_likelihood(self, poses: Array, scan: Scan) -> Array:
        """Log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
        sd = math.hypot(self.sigma_hit, scan.extra_sd)
        centre = np.array([scan.robot_from_scan.x, scan.robot_from_scan.y])
        return beam_log_likelihoods(
            poses,
            centre,
            self._rays(scan),
            self.edges,
            self.range_max,
            sd,
            self.z_hit / (sd * math.sqrt(2 * math.pi)),
            self.z_rand / self.range_max,
            math.log(self.z_max),
        )

    def count_rays(self, poses: Array, scan: Scan) -> int:
        """How many rays the log-likelihood is the sum of: also those that did not return."""
        return len(self._rays(scan))

    def counted(self, scan: Scan) -> NDArray[np.intp]:
        """Indices of the rays that the log-likelihood is the sum of."""
        return evenly(len(scan.ranges), self.max_beams)

    def _rays(self, scan: Scan) -> Array:
        """What of the rays (k, 7) is the same for all poses.

        Direction in the robot frame (2), range, p of a range cut short, where sight begins, and
        from where to where an edge is surely seen: before anything that may hide one.
        """
        used = self.counted(scan)
        rays = np.empty((len(used), 7))
        rays[:, :2] = heading_vectors(scan.robot_from_scan.theta + scan.bearings[used])
        rays[:, 2] = scan.ranges[used]
        rays[:, 3] = self.z_short * self.lambda_short * np.exp(-self.lambda_short * rays[:, 2])
        if scan.sight is None:
            rays[:, 4:] = 0.0, 0.0, self.range_max
        else:
            near, far = scan.sight[used].T
            surely = np.minimum(far - FAR, self.range_max)
            rays[:, 4:] = np.column_stack([near, near + NEAR, surely])
        if scan.hidden is not None:
            rays[:, 6] = np.minimum(rays[:, 6], scan.hidden[used, 0] - NEAR)
        # A ray that sees nothing anywhere has no opinion.
        return rays[~np.isnan(rays[:, 4])]
