"""Table 6.3: the likelihood field range finder model."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from robot.geometry import Array
from robot.localization.models.sensor_parameters import SensorParameters


def likelihood_field_range_finder_model(
    poses: Array,
    bearings: Array,
    ranges: Array,
    distance: Callable[[Array, Array], Array],
    p: SensorParameters,
) -> Array:
    """Return the log-likelihood (n,) of a scan at poses (n, 3), up to a constant.

    Args:
        poses: (n, 3) [m, m, rad] in the map; rays start at the robot's origin.
        bearings: (k,) [rad] of the rays, in the robot frame.
        ranges: (k,) [m]; rays without a return (``inf``) are ignored, as in the book.
        distance: the distance [m] of points (m, 2) from the nearest edge; the book's edges face
            everywhere, those of tape face one side, so it takes the rays' headings (m,) as well.
        p: z_hit, z_rand, sigma_hit, sigma_slope and laser_max_range.
    """
    returned = np.isfinite(ranges)
    z, phi = ranges[returned], bearings[returned]
    # Far floor is seen less exactly: the spread grows with the square of the range.
    sigma = p.sigma_hit * (1 + p.sigma_slope * z**2)

    log_q = np.zeros(len(poses))
    for n, (x, y, theta) in enumerate(poses):
        ends = np.column_stack([x + z * np.cos(theta + phi), y + z * np.sin(theta + phi)])
        dist = distance(ends, theta + phi)
        q = p.z_hit * np.exp(-(dist**2) / (2 * sigma**2)) + p.z_rand / p.laser_max_range
        log_q[n] = np.log(q).sum()
    return log_q
