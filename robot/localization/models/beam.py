"""Beam model: a scan fits a pose when its rays, cast there, are as long."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, compose
from robot.scan import Scan, evenly


@dataclass(frozen=True)
class Beam:
    """Beam range finder model (Probabilistic Robotics, Table 6.1), rays cast at the exact edges.

    p = z_hit N(z; z*, sigma_hit) + z_short lambda_short exp(-lambda_short z) [z <= z*] +
    z_max [no return] + z_rand / range_max. Unlike the field it knows that an edge hides what lies
    behind it, and that a ray that should have returned did not.
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
        used = evenly(len(scan.ranges), self.max_beams)
        ranges = scan.ranges[used]
        bearings = scan.bearings[used] + scan.robot_from_scan.theta
        starts = compose(poses, Pose2(scan.robot_from_scan.x, scan.robot_from_scan.y).to_array())
        expected = np.empty((len(poses), len(ranges)))
        cast_rays(starts, bearings, self.edges, self.range_max, expected)
        likelihood: Array = np.log(self._likelihood(ranges, expected, scan.extra_sd)).sum(axis=1)
        return likelihood

    def _likelihood(self, ranges: Array, expected: Array, extra_sd: float) -> Array:
        sd = math.hypot(self.sigma_hit, extra_sd)
        returned = np.isfinite(ranges)
        z = np.where(returned, ranges, 0.0)
        met = np.isfinite(expected)
        off = z - np.where(met, expected, 0.0)
        hit = np.where(met, np.exp(-0.5 * np.square(off / sd)) / (sd * math.sqrt(2 * math.pi)), 0.0)
        short = np.where(z <= expected, self.lambda_short * np.exp(-self.lambda_short * z), 0.0)
        seen = self.z_hit * hit + self.z_short * short + self.z_rand / self.range_max
        # Where the map has nothing in reach, no return is what is expected.
        unseen = np.where(met, self.z_max, 1.0)
        return np.where(returned, seen, unseen)
