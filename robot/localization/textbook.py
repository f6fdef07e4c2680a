"""The textbook's algorithms, as Probabilistic Robotics (Thrun, Burgard, Fox) prints them, in NumPy.

The program runs compiled versions (``robot.localization.kernels``, ``robot.localization.models``).
These tables are for reading, and the tests compare the compiled versions with them.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from robot.fields.edge_index import EdgeIndex
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.models.sensor_models import SensorParameters
from robot.scan import Scan

SampleMotionModel = Callable[[Array, Pose2, np.random.Generator], Array]
"""Poses (n, 3) and a step by odometry to poses (n, 3)."""
MeasurementModel = Callable[[Array, Scan], Array]
"""Poses (n, 3) and a scan to log-likelihoods (n,)."""


def low_variance_sampler(weights: Array, count: int, rng: np.random.Generator) -> list[int]:
    """Table 4.4, low variance resampling: indices of ``count`` particles, drawn by weight.

    The weights (n,) sum to one.
    """
    drawn = []
    r = rng.random() / count
    c = weights[0]
    i = 0
    for m in range(count):
        u = r + m / count
        while u > c and i < len(weights) - 1:
            i = i + 1
            c = c + weights[i]
        drawn.append(i)
    return drawn


def sample_motion_model_odometry(
    poses: Array,
    moved: Pose2,
    alphas: tuple[float, float, float, float],
    rng: np.random.Generator,
) -> Array:
    """Table 5.6, odometry motion model: poses (n, 3) after a step, each drawn at random.

    Args:
        poses: (n, 3) [m, m, rad] before the step.
        moved: the step by odometry, seen from its start; the book writes it as two poses.
        alphas: alpha1 to alpha4 as shares of variances, as in the book's table and in nav2.
        rng: source of the random numbers.
    """
    alpha1, alpha2, alpha3, alpha4 = alphas
    n = len(poses)

    rot1 = np.arctan2(moved.y, moved.x)
    trans = np.hypot(moved.x, moved.y)
    rot2 = wrap_angle(moved.theta - rot1)

    rot1_hat = rot1 - rng.normal(0, np.sqrt(alpha1 * rot1**2 + alpha2 * trans**2), n)
    trans_hat = trans - rng.normal(0, np.sqrt(alpha3 * trans**2 + alpha4 * (rot1**2 + rot2**2)), n)
    rot2_hat = rot2 - rng.normal(0, np.sqrt(alpha1 * rot2**2 + alpha2 * trans**2), n)

    x, y, theta = poses.T
    return np.column_stack(
        [
            x + trans_hat * np.cos(theta + rot1_hat),
            y + trans_hat * np.sin(theta + rot1_hat),
            np.array([wrap_angle(angle) for angle in theta + rot1_hat + rot2_hat]),
        ]
    )


def beam_range_finder_model(
    poses: Array, bearings: Array, ranges: Array, edges: EdgeIndex, p: SensorParameters
) -> Array:
    """Table 6.1, beam model: the log-likelihood (n,) of a scan at poses (n, 3).

    Two things differ from the book. The densities are not normalized over 0 to z_max, as in nav2.
    A ray without a return has the range ``inf``; where no edge is due, that is certain. It runs as
    ``models/beam.py``.

    Args:
        poses: (n, 3) [m, m, rad] in the map; rays start at the robot's origin.
        bearings: (k,) [rad] of the rays, in the robot frame.
        ranges: (k,) [m], ``inf`` without a return.
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


def likelihood_field_range_finder_model(
    poses: Array,
    bearings: Array,
    ranges: Array,
    distance: Callable[[Array, Array], Array],
    p: SensorParameters,
) -> Array:
    """Table 6.3, likelihood field: log-likelihood (n,) of a scan at poses (n, 3), up to a constant.

    With ``sigma_slope`` 0 and a distance that ignores headings it is the book's, but that the
    Gaussian is not normalized, as in nav2. It runs as ``models/likelihood_field.py``, from tables.

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


def mcl(
    poses: Array,
    moved: Pose2,
    scan: Scan,
    sample_motion_model: SampleMotionModel,
    measurement_model: MeasurementModel,
    rng: np.random.Generator,
) -> Array:
    """Table 8.2, Monte Carlo localization: particles (n, 3) after one step and one scan.

    The program's filter (``robot.localization.particles``) adds to this: KLD sampling (Table 8.4),
    clusters, tempered likelihoods, and copies that are spread out.
    """
    poses = sample_motion_model(poses, moved, rng)

    log_likelihood = measurement_model(poses, scan)
    weights = np.exp(log_likelihood - log_likelihood.max())
    weights = weights / weights.sum()

    result: Array = poses[low_variance_sampler(weights, len(poses), rng)]
    return result
