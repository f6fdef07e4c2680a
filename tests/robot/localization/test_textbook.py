"""The compiled models and samplers do what the book's tables say, page by page."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from entry_reading import distance_at
from sensor_trials import BEARINGS, ENTRIES, FIELD, PARAMETERS, TRUTH, entry_distances, scan_at

from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.kernels.entry_planes import DIRECTIONS
from robot.localization.models.motion_models import DifferentialMotion
from robot.localization.models.sensor_models import sensor_model
from robot.localization.particles.resampling import low_variance
from robot.localization.textbook import (
    beam_range_finder_model,
    likelihood_field_range_finder_model,
    low_variance_sampler,
    mcl,
    sample_motion_model_odometry,
)
from robot.scan import Scan

ALPHAS = (0.05, 0.02, 0.03, 0.01)
STEP = Pose2(0.06, 0.02, 0.5)


def near_truth(count: int, seed: int = 0) -> Array:
    noise = np.random.default_rng(seed).normal(0, [0.02, 0.02, 0.05], (count, 3))
    return TRUTH.to_array() + noise


def table_distances(ends: Array, headings: Array) -> Array:
    """The distances that the compiled look-up reads, in plain NumPy."""
    column, row = ((ends - ENTRIES.origin) / ENTRIES.resolution).T
    direction = np.floor(headings * DIRECTIONS / (2 * math.pi) + 0.5) % DIRECTIONS
    position = direction, row, column
    return distance_at(ENTRIES.planes, ENTRIES.resolution, ENTRIES.max_distance, position)


def test_table_5_6_the_odometry_motion_model() -> None:
    count = 100_000
    poses = np.tile([0.3, -0.2, 3.0], (count, 1))
    ours = DifferentialMotion(*ALPHAS).sample(poses, STEP, np.random.default_rng(0))
    books = sample_motion_model_odometry(poses, STEP, ALPHAS, np.random.default_rng(1))
    for one in (ours, books):  # both sides of half a turn
        one[:, 2] = [wrap_angle(theta - 3.0) for theta in one[:, 2]]
    spread = books.std(axis=0)
    np.testing.assert_allclose(ours.mean(axis=0), books.mean(axis=0), atol=0.02 * spread.max())
    np.testing.assert_allclose(np.cov(ours.T), np.cov(books.T), atol=0.02 * spread.max() ** 2)


def test_table_6_1_the_beam_model() -> None:
    p = replace(PARAMETERS, laser_model_type="beam", max_beams=len(BEARINGS))
    scan = scan_at(TRUTH, sd=0.01)
    poses = near_truth(200)
    ours = sensor_model(p, ENTRIES, FIELD.edges).log_likelihood(poses, scan)
    books = beam_range_finder_model(poses, scan.bearings, scan.ranges, FIELD.edge_index, p)
    # An edge close to where sight ends may be missed, which the book does not know.
    due = np.empty((len(poses), len(BEARINGS)))
    cast_rays(poses, BEARINGS, FIELD.edge_index, p.laser_max_range, due)
    at_end = ((due > p.laser_max_range - 0.09) & np.isfinite(due) & ~scan.hit).any(axis=1)
    assert (~at_end).sum() > 50
    np.testing.assert_allclose(ours[~at_end], books[~at_end], rtol=1e-9)


@pytest.mark.parametrize("name", ["the table's distances", "exact distances"])
def test_table_6_3_the_likelihood_field(name: str) -> None:
    distance = table_distances if name.startswith("the table") else entry_distances
    p = replace(PARAMETERS, sigma_hit=0.02, max_beams=len(BEARINGS))
    scan, poses = scan_at(TRUTH), near_truth(30)
    ours = sensor_model(p, ENTRIES, FIELD.edges).log_likelihood(poses, scan)
    books = likelihood_field_range_finder_model(poses, scan.bearings, scan.ranges, distance, p)
    off = ours - books
    # The polynomial is right to 1e-3 a ray, the table's words to 20 um; cells of 5 mm blur where
    # distances bend.
    within = 1.5e-3 * scan.hit.sum() if distance is table_distances else 0.02 * np.ptp(books)
    np.testing.assert_allclose(off, off.mean(), atol=within)
    assert np.ptp(books) > 20


@pytest.mark.parametrize("seed", range(5))
def test_table_4_4_low_variance_resampling(seed: int) -> None:
    weights = np.random.default_rng(seed).random(300) ** 4
    weights /= weights.sum()
    ours = low_variance(weights, 500, np.random.default_rng(seed))
    books = low_variance_sampler(weights, 500, np.random.default_rng(seed))
    # A tooth of the comb that meets the edge between two particles may fall to either.
    assert np.mean(ours != books) < 0.01


def test_table_8_2_monte_carlo_localization_finds_the_robot() -> None:
    """From a cloud of 10 cm to millimetres, with the book's pages alone."""
    p = replace(PARAMETERS, sigma_hit=0.02)
    rng = np.random.default_rng(0)
    poses = TRUTH.to_array() + rng.normal(0, [0.03, 0.03, 0.1], (400, 3))

    def motion(poses: Array, moved: Pose2, rng: np.random.Generator) -> Array:
        return sample_motion_model_odometry(poses, moved, ALPHAS, rng)

    def measurement(poses: Array, scan: Scan) -> Array:
        some = slice(None, None, 6)
        return likelihood_field_range_finder_model(
            poses, scan.bearings[some], scan.ranges[some], table_distances, p
        )

    true = TRUTH
    for _ in range(8):
        moved = Pose2(0.01, 0.0, 0.08)
        true = true @ moved
        poses = mcl(poses, moved, scan_at(true), motion, measurement, rng)
    mean = poses.mean(axis=0)
    assert math.hypot(mean[0] - true.x, mean[1] - true.y) < 0.01
    assert abs(wrap_angle(mean[2] - true.theta)) < 0.05
