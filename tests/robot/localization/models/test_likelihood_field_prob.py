"""Rays that hardly any particle explains are skipped, unless that is most of them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sensor_trials import (
    BEARINGS,
    ENTRIES,
    FIELD,
    PARAMETERS,
    TRUTH,
    entry_distances,
    model_of,
    scan_at,
)

from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.models.sensor_models import sensor_model
from robot.scan import Scan


def skipping(**changes: Any) -> LikelihoodFieldProb:
    fixed = {"do_beamskip": True, "beam_skip_distance": 0.02, "sigma_hit": 0.008, "max_beams": 61}
    given = {**fixed, **changes}
    parameters = replace(PARAMETERS, laser_model_type="likelihood_field_prob", **given)
    made = sensor_model(parameters, ENTRIES, FIELD.edges)
    assert isinstance(made, LikelihoodFieldProb)
    return made


PLAIN = model_of("likelihood_field", sigma_hit=0.008, max_beams=61)
NEAR = TRUTH.to_array() + np.random.default_rng(2).normal(0, [0.004, 0.004, 0.01], (200, 3))
"""A cloud around the truth, much narrower than ``beam_skip_distance``."""


def blocked(share: float) -> Scan:
    """The scan from the truth, a share of its rays ending at shoes just before the tape."""
    scan = scan_at(TRUTH)
    ranges = scan.ranges.copy()
    ranges[: round(share * len(ranges))] -= 0.045
    return replace(scan, ranges=ranges)


def only(scan: Scan, rays: NDArray[np.bool_]) -> Scan:
    return replace(scan, bearings=scan.bearings[rays], ranges=scan.ranges[rays])


def agree(one: Array, other: Array) -> None:
    """Two log-likelihoods, each up to a constant."""
    np.testing.assert_allclose(one - one.mean(), other - other.mean(), rtol=1e-4, atol=1e-3)
    assert np.ptp(one) > 1


def test_without_skipping_it_is_the_likelihood_field() -> None:
    for poses in (NEAR, FIELD.free_poses(np.random.default_rng(0), 300)):
        for share in (0.0, 0.3):
            found = skipping(do_beamskip=False).log_likelihood(poses, blocked(share))
            np.testing.assert_array_equal(found, PLAIN.log_likelihood(poses, blocked(share)))


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.0, 0.2, 0.6])
@pytest.mark.parametrize("distance", [0.015, 0.025])
def test_a_ray_agrees_with_the_particles_that_put_its_end_near_an_edge(
    share: float, distance: float
) -> None:
    """By exact distances, which the table's cells blur by less than 2 mm."""
    scan, cloud = blocked(share), np.add(NEAR[:60], (0.006, 0, 0))
    off = np.array(
        [
            entry_distances(Pose2(*pose).apply(scan.points()), pose[2] + scan.bearings)
            for pose in cloud.tolist()
        ]
    )
    found = skipping(beam_skip_distance=distance)._agreeing(cloud, scan.points(), scan)
    assert ((off < distance - 0.002).mean(axis=0) <= found + 1e-12).all()
    assert (found <= (off < distance + 0.002).mean(axis=0) + 1e-12).all()


@pytest.mark.parametrize("threshold", [0.0, 0.3, 0.7])
@pytest.mark.parametrize("distance", [0.015, 0.025])
def test_rays_that_agree_with_too_few_particles_are_skipped(
    threshold: float, distance: float
) -> None:
    scan, cloud = blocked(0.6), np.add(NEAR, (0.006, 0, 0))
    model = skipping(beam_skip_distance=distance, beam_skip_threshold=threshold)
    kept = model._agreeing(cloud, scan.points(), scan) > threshold
    assert 10 < kept.sum() < 61
    agree(model.log_likelihood(cloud, scan), PLAIN.log_likelihood(cloud, only(scan, kept)))


def test_what_stands_before_the_tape_costs_nothing_when_it_is_skipped() -> None:
    """The cloud is judged by the other rays alone, as if nothing stood there."""
    rest = only(scan_at(TRUTH), np.arange(61) >= 18)
    agree(skipping().log_likelihood(NEAR, blocked(0.3)), PLAIN.log_likelihood(NEAR, rest))


def test_rays_that_are_skipped_are_not_counted() -> None:
    scan = blocked(0.3)
    assert skipping().count_rays(NEAR, scan) == 61 - 18
    assert skipping(do_beamskip=False).count_rays(NEAR, scan) == 61
    assert skipping(beam_skip_error_threshold=0.2).count_rays(NEAR, scan) == 61
    assert skipping().count_rays(NEAR, replace(scan, ranges=np.full(61, np.inf))) == 0


def test_when_too_many_rays_would_be_skipped_all_count() -> None:
    """Else a wrong cloud would skip what proves it wrong."""
    scan, rest = blocked(0.3), only(scan_at(TRUTH), np.arange(61) >= 18)
    bold, shy = (
        skipping(beam_skip_error_threshold=share).log_likelihood(NEAR, scan) for share in (0.5, 0.2)
    )
    agree(bold, PLAIN.log_likelihood(NEAR, rest))
    agree(shy, PLAIN.log_likelihood(NEAR, scan))
    assert np.abs(bold - bold.mean() - (shy - shy.mean())).max() > 1
    nothing_fits = skipping(beam_skip_threshold=1.0).log_likelihood(NEAR, scan)
    agree(nothing_fits, PLAIN.log_likelihood(NEAR, scan))


def test_with_skipping_too_it_is_one_finite_number_a_particle() -> None:
    empty = Scan(0.0, BEARINGS, np.full(61, np.inf))
    for cloud in (NEAR, NEAR[:1], NEAR[:0], np.full((3, 3), 1e6)):
        for scan in (scan_at(TRUTH), blocked(0.5), blocked(1.0), empty):
            before = cloud.copy()
            found = skipping().log_likelihood(cloud, scan)
            assert found.shape == (len(cloud),)
            assert np.isfinite(found).all()
            np.testing.assert_array_equal(found, skipping().log_likelihood(cloud, scan))
            np.testing.assert_array_equal(cloud, before)


def test_a_cloud_wider_than_the_distance_skips_nothing() -> None:
    rng = np.random.default_rng(2)
    wide = TRUTH.to_array() + rng.normal(0, [0.1, 0.1, 0.3], (300, 3))
    turned = TRUTH.to_array() + rng.normal(0, [0, 0, 0.3], (300, 3))
    for cloud in (wide, turned, FIELD.free_poses(rng, 300)):
        scan = blocked(0.3)
        agree(skipping().log_likelihood(cloud, scan), PLAIN.log_likelihood(cloud, scan))


def test_a_heading_on_either_side_of_the_half_turn_is_no_wide_cloud() -> None:
    back = TRUTH @ Pose2(0, 0, math.pi - TRUTH.theta)
    scan = scan_at(back)
    ranges = scan.ranges.copy()
    ranges[:18] -= 0.045
    cloud = back.to_array() + np.random.default_rng(0).normal(0, [0.002, 0.002, 0.01], (200, 3))
    cloud[:, 2] = wrap_angle(cloud[:, 2])
    assert np.ptp(cloud[:, 2]) > 6
    rest = only(scan, np.arange(61) >= 18)
    found = skipping().log_likelihood(cloud, replace(scan, ranges=ranges))
    agree(found, PLAIN.log_likelihood(cloud, rest))
