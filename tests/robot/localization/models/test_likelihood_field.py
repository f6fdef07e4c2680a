"""The likelihood field is its book's formula, number by number, up to a constant."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from sensor_trials import (
    BEARINGS,
    ENTRIES,
    FIELD,
    PARAMETERS,
    TRUTH,
    at,
    entry_distances,
    model_of,
    scan_at,
)

from robot.geometry import Pose2
from robot.localization.models.sensor_models import sensor_model
from robot.scan import Scan


@pytest.mark.parametrize("extra_sd", [0.0, 0.01])
def test_the_likelihood_field_is_the_books_formula(extra_sd: float) -> None:
    """Table 6.3, over exact distances to the edges; the table's cells may blur it a little.

    The spread of a range grows with its square.
    """
    p = replace(PARAMETERS, sigma_hit=0.02, max_beams=61)
    model = sensor_model(p, ENTRIES, FIELD.edges)
    scan = replace(scan_at(TRUTH), extra_sd=extra_sd)
    poses = TRUTH.to_array() + np.random.default_rng(0).normal(0, [0.02, 0.02, 0.05], (30, 3))
    sd = np.hypot(0.02 * (1 + p.sigma_slope * scan.ranges[scan.hit] ** 2), extra_sd)
    expected = []
    for x, y, theta in poses:
        ends = Pose2(x, y, theta).apply(scan.points())
        d = entry_distances(ends, theta + BEARINGS[scan.hit])
        expected.append(
            np.log(p.z_hit * np.exp(-(d**2) / (2 * sd**2)) + p.z_rand / p.laser_max_range).sum()
        )
    off = model.log_likelihood(poses, scan) - expected
    np.testing.assert_allclose(off, off.mean(), atol=0.02 * np.ptp(expected))
    assert np.ptp(expected) > 20


@pytest.mark.slow
def test_rays_without_a_return_say_nothing_to_the_likelihood_field() -> None:
    model = model_of("likelihood_field", max_beams=61)
    scan = scan_at(TRUTH)
    holes = scan.ranges.copy()
    holes[::2] = np.inf
    shorter = Scan(0.0, BEARINGS[1::2], scan.ranges[1::2])
    poses = FIELD.free_poses(np.random.default_rng(0), 50)
    np.testing.assert_array_equal(
        model.log_likelihood(poses, replace(scan, ranges=holes)),
        model.log_likelihood(poses, shorter),
    )
    empty = replace(scan, ranges=np.full(61, np.inf))
    assert np.ptp(model.log_likelihood(poses, empty)) == 0


def test_an_end_beyond_the_greatest_distance_counts_as_that_far() -> None:
    model = model_of("likelihood_field")
    ray = Scan(0.0, np.zeros(1), np.array([0.1]))
    far = model.log_likelihood(np.array([[0.0, 0.0, 2.0], [-0.1, 0.1, 1.0], [9, 9, 0]]), ray)
    np.testing.assert_allclose(far, far[0], atol=2e-3)
    there = at(model, TRUTH, scan_at(TRUTH, bearings=np.zeros(1)))
    peak = 1 + PARAMETERS.z_hit * PARAMETERS.laser_max_range / PARAMETERS.z_rand
    assert there - far[0] == pytest.approx(math.log(peak), abs=0.05)


@pytest.mark.parametrize("count", [1, 15, 16, 511, 513, 1100])
def test_a_pose_is_weighed_alike_alone_and_among_any_number(count: int) -> None:
    model, scan = model_of("likelihood_field"), scan_at(TRUTH)
    poses = FIELD.free_poses(np.random.default_rng(0), count)
    together = model.log_likelihood(poses, scan)
    alone = [model.log_likelihood(poses[i : i + 1], scan)[0] for i in range(0, count, 7)]
    np.testing.assert_array_equal(together[::7], alone)


def test_a_heading_counts_the_same_some_turns_on() -> None:
    model, scan = model_of("likelihood_field"), scan_at(TRUTH)
    poses = FIELD.free_poses(np.random.default_rng(0), 100)
    turned = poses + np.array([0.0, 0.0, 4 * math.pi])
    np.testing.assert_allclose(
        model.log_likelihood(poses, scan), model.log_likelihood(turned, scan), atol=1e-3
    )
