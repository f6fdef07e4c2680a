"""Beam model: a scan fits a pose if rays cast from there have the same lengths."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from robot.fields.edge_index import EdgeIndex
from robot.geometry import Array, heading_vectors
from robot.localization.kernels.beam_sums import beam_log_likelihoods
from robot.scan import Scan, evenly

MISSED_AT_START, MISSED_AT_END = 0.02, 0.08
"""An edge closer than this to the start or the end of a ray's sight [m] may be missed, because the
scanner must see the whole tape. Its far edge is 50 mm behind, or more if the ray crosses at a
slant. ``ray_evidence`` reckons with the slant of each ray, by margins of its own."""


@dataclass(frozen=True)
class Beam:
    """Beam range finder model (Probabilistic Robotics, Table 6.1), with rays cast at exact edges.

    p = z_hit N(z; z*, sigma_hit) + z_short lambda_short exp(-lambda_short z) [z <= z*] +
    z_max [no return] + z_rand / range_max. Unlike the likelihood field, it knows that an edge hides
    what lies behind it. It also counts a ray without a return: its p is z_max where an edge should
    be in sight, and one where none is.
    """

    edges: EdgeIndex = field(repr=False)
    """The field's edges."""
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
        """Return the log-likelihood (n,) of a scan at poses (n, 3), up to a constant."""
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
        """Return how many rays the log-likelihood is the sum of; rays without a return count."""
        return len(self._rays(scan))

    def counted(self, scan: Scan) -> NDArray[np.intp]:
        """Return the indices of the rays that the log-likelihood is the sum of."""
        return evenly(len(scan.ranges), self.max_beams)

    def _rays(self, scan: Scan) -> Array:
        """Return what does not depend on the pose (k, 7), for each ray.

        The columns are: direction in the robot frame (2), range, p of a range that was cut short,
        where sight begins, and from where to where an edge is surely seen. That ends before
        anything that may hide an edge.
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
            surely = np.minimum(far - MISSED_AT_END, self.range_max)
            rays[:, 4:] = np.column_stack([near, near + MISSED_AT_START, surely])
        if scan.hidden is not None:
            rays[:, 6] = np.minimum(rays[:, 6], scan.hidden[used, 0] - MISSED_AT_START)
        # A ray that is out of sight says nothing.
        return rays[~np.isnan(rays[:, 4])]
