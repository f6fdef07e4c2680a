"""Table 6.1: the beam range finder model."""

from __future__ import annotations

import math

import numpy as np

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array
from robot.localization.models.sensor_parameters import SensorParameters


def beam_range_finder_model(
    poses: Array, bearings: Array, ranges: Array, edges: EdgeIndex, p: SensorParameters
) -> Array:
    """Return the log-likelihood (n,) of a scan at poses (n, 3).

    Two things differ from the book. The densities are not normalized over 0 to z_max, as in nav2.
    And a ray without a return is told by ``inf``: where no edge is due it is sure to be missing.

    Args:
        poses: (n, 3) [m, m, rad] in the map; rays start at the robot's origin.
        bearings: (k,) [rad] of the rays, in the robot frame.
        ranges: (k,) [m], ``inf`` without a return.
        edges: the map.
        p: z_hit, z_short, z_max, z_rand, sigma_hit, lambda_short and laser_max_range.
    """
    z_star = np.empty((len(poses), len(bearings)))
    cast_rays(poses, bearings, edges, p.laser_max_range, z_star)

    returned = np.isfinite(ranges)
    z, expected = ranges[returned], z_star[:, returned]
    p_hit = np.exp(-((z - expected) ** 2) / (2 * p.sigma_hit**2)) / math.sqrt(
        2 * math.pi * p.sigma_hit**2
    )
    p_short = np.where(z <= expected, p.lambda_short * np.exp(-p.lambda_short * z), 0.0)
    p_rand = 1 / p.laser_max_range
    q = p.z_hit * p_hit + p.z_short * p_short + p.z_rand * p_rand

    p_max = np.where(np.isfinite(z_star[:, ~returned]), p.z_max, 1.0)
    result: Array = np.log(q).sum(axis=1) + np.log(p_max).sum(axis=1)
    return result
