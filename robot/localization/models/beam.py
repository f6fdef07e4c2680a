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

    def count_rays(self, poses: Array, scan: Scan) -> int:
        """How many rays the log-likelihood is the sum of: also those that did not return."""
        return len(self._rays(scan))

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
            surely = np.minimum(far - FAR, self.range_max)
            rays[:, 4:] = np.column_stack([near, near + NEAR, surely])
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
    # By rows, so that the compiler works on several rays at a time.
    rays = np.ascontiguousarray(rays.T)
    fan = np.empty((3, rays.shape[1]))
    for i in range(len(poses)):
        c, s = math.cos(poses[i, 2]), math.sin(poses[i, 2])
        x = poses[i, 0] + c * centre[0] - s * centre[1]
        y = poses[i, 1] + s * centre[0] + c * centre[1]
        _cast_fan(x, y, c, s, rays, edges, range_max, fan)
        result[i] = _log_likelihood(rays, fan[2], sd, hit, false, log_missed)
    return result


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def _cast_fan(
    x: float,
    y: float,
    c: float,
    s: float,
    rays: Array,
    index: EdgeIndex,
    range_max: float,
    fan: Array,
) -> None:
    """Fill the last row of ``fan`` (3, k) with where rays from one place should end [m]."""
    dx, dy, expected = fan[0], fan[1], fan[2]
    near = rays[4]
    for j in range(len(near)):
        dx[j], dy[j] = c * rays[0, j] - s * rays[1, j], s * rays[0, j] + c * rays[1, j]
        expected[j] = math.inf
    if index.columns * index.rows > 1:
        for j in range(len(near)):
            start_x, start_y = x + near[j] * dx[j], y + near[j] * dy[j]
            result, _ = cast_toward(start_x, start_y, dx[j], dy[j], index, range_max - near[j])
            expected[j] = near[j] + result
        return
    for edge in range(len(index.edges)):
        x0, y0 = index.edges[edge, 0] - x, index.edges[edge, 1] - y
        x1, y1 = index.edges[edge, 2] - x, index.edges[edge, 3] - y
        _meet(x0, y0, x1, y1, dx, dy, near, expected)
    for j in range(len(near)):
        if expected[j] > range_max:
            expected[j] = math.inf


@njit(cache=True, nogil=True, error_model="numpy")
def _meet(
    x0: float,
    y0: float,
    x1: float,
    y1: float,
    dx: Array,
    dy: Array,
    near: Array,
    expected: Array,
) -> None:
    """Shorten rays from the origin that meet an edge: as ``cast_toward``, several at a time.

    For that there is no branch in the loop, and the function is not inlined.
    """
    across = y0 * x1 - x0 * y1
    for j in range(len(dx)):
        side0, side1 = x0 * dy[j] - y0 * dx[j], x1 * dy[j] - y1 * dx[j]
        along = across / (side1 - side0)
        met = (side0 <= 0.0) & (side1 >= 0.0) & (side0 < side1) & (along >= near[j])
        expected[j] = along if met & (along < expected[j]) else expected[j]


@njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
def _log_likelihood(
    rays: Array, expected: Array, sd: float, hit: float, false: float, log_missed: float
) -> float:
    """Table 6.1 for one pose."""
    total, product = 0.0, 1.0
    for j in range(len(expected)):
        z = rays[2, j]
        if z == math.inf:
            if rays[5, j] <= expected[j] <= rays[6, j]:
                total += log_missed
            continue
        p = false + (rays[3, j] if z <= expected[j] else 0.0)
        offset = (z - expected[j]) / sd
        # Beyond that, a normal distribution is less than rounding.
        if -8.0 < offset < 8.0:
            p += hit * math.exp(-0.5 * offset * offset)
        # One logarithm for many factors, before they leave the range of numbers.
        product *= p
        if not 1e-100 < product < 1e100:
            total += math.log(product)
            product = 1.0
    return total + math.log(product)
