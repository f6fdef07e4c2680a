"""Beam model: a scan fits a pose when its rays, cast there, are as long."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_toward
from robot.geometry import Array, heading_vectors
from robot.scan import Scan, evenly

SIGHT_MARGIN = 0.02
"""An edge so close to where a ray's sight begins or ends [m] may be missed: tape is seen whole."""


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
        return _log_likelihoods(
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

    def _rays(self, scan: Scan) -> Array:
        """What of the rays (k, 7) is the same for all poses.

        Direction in the robot frame (2), range, p of a range cut short, where sight begins, and
        from where to where an edge is surely seen.
        """
        used = evenly(len(scan.ranges), self.max_beams)
        rays = np.empty((len(used), 7))
        rays[:, :2] = heading_vectors(scan.robot_from_scan.theta + scan.bearings[used])
        rays[:, 2] = scan.ranges[used]
        rays[:, 3] = self.z_short * self.lambda_short * np.exp(-self.lambda_short * rays[:, 2])
        if scan.sight is None:
            rays[:, 4:] = 0.0, 0.0, self.range_max
        else:
            near, far = scan.sight[used].T
            rays[:, 4:] = np.column_stack([near, near + SIGHT_MARGIN, far - SIGHT_MARGIN])
        # A ray that sees nothing anywhere has no opinion.
        return rays[~np.isnan(rays[:, 4])]


@njit(cache=True, nogil=True, error_model="numpy")
def _log_likelihoods(
    poses: Array,
    centre: Array,
    rays: Array,
    edges: EdgeIndex,
    range_max: float,
    sd: float,
    hit: float,
    false: float,
    log_missed: float,
) -> Array:
    result = np.empty(len(poses))
    for i in range(len(poses)):
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        x = poses[i, 0] + c * centre[0] - s * centre[1]
        y = poses[i, 1] + s * centre[0] + c * centre[1]
        total, product = 0.0, 1.0
        for j in range(len(rays)):
            dx, dy = c * rays[j, 0] - s * rays[j, 1], s * rays[j, 0] + c * rays[j, 1]
            z, short, near = rays[j, 2], rays[j, 3], rays[j, 4]
            expected, _ = cast_toward(x + near * dx, y + near * dy, dx, dy, edges, range_max - near)
            expected += near
            if z == math.inf:
                if rays[j, 5] <= expected <= rays[j, 6]:
                    total += log_missed
                continue
            p = false
            if z <= expected:
                p += short
            off = (z - expected) / sd
            # Beyond that, a normal distribution is less than rounding.
            if -8.0 < off < 8.0:
                p += hit * math.exp(-0.5 * off * off)
            # One logarithm for many factors, before they leave the range of numbers.
            product *= p
            if not 1e-100 < product < 1e100:
                total += math.log(product)
                product = 1.0
        result[i] = total + math.log(product)
    return result
