"""Every sensor model likes the truth best, and keeps its promises."""

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
    beam_of,
    model_of,
    scan_at,
)

from robot.geometry import Pose2
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.models.sensor_models import (
    SENSOR_MODELS,
    SensorModel,
    count_rays,
    sensor_model,
)
from robot.scan import Scan


@pytest.fixture(params=SENSOR_MODELS)
def model(request: pytest.FixtureRequest) -> SensorModel:
    return model_of(request.param)


# --- what every sensor model promises


def test_it_is_one_finite_number_a_particle(model: SensorModel) -> None:
    for count in (0, 1, 300):
        poses = FIELD.free_poses(np.random.default_rng(0), count or 1)[:count]
        found = model.log_likelihood(poses, scan_at(TRUTH))
        assert found.shape == (count,)
        assert np.isfinite(found).all()


def test_the_truth_is_likelier_than_what_is_near_it(model: SensorModel) -> None:
    """Over 40 places, each against 60 poses a few centimetres and degrees off."""
    rng = np.random.default_rng(0)
    gaps = []
    for values in FIELD.free_poses(rng, 40):
        scan = scan_at(Pose2.from_array(values), sd=0.0005)
        if scan.hit.sum() < 20:
            continue
        off = rng.normal(0, [0.03, 0.03, 0.1], (60, 3))
        likelihoods = model.log_likelihood(np.vstack([values, values + off]), scan)
        gaps.append(likelihoods[0] - likelihoods[1:])
    assert len(gaps) > 25
    assert np.mean(gaps) > 20
    assert np.mean(np.array(gaps) < 0) < 0.01
    assert all(gap.mean() > 0 for gap in gaps)


def test_farther_from_the_truth_is_less_likely(model: SensorModel) -> None:
    """Step by step across the wall ahead, and step by step turned away."""
    truth = Pose2(0.05, 0.3, 0.0)
    scan = scan_at(truth)
    for step in (Pose2(0.004), Pose2(-0.004), Pose2(0, 0, 0.01), Pose2(0, 0, -0.01)):
        away, likelihoods = truth, []
        for _ in range(6):
            likelihoods.append(at(model, away, scan))
            away = away @ step
        assert (np.diff(likelihoods) < 0).all()


def test_depth_behind_an_edge_is_never_mistaken_for_the_edge(model: SensorModel) -> None:
    """A robot that is ahead of itself sees its wall as if from within the tape."""
    truth = Pose2(0.05, 0.3, 0.0)
    scan = scan_at(truth)
    likelihoods = [at(model, truth @ Pose2(x), scan) for x in np.arange(0, 0.04, 0.001)]
    assert likelihoods[0] == max(likelihoods)
    # 8 mm: one spread of a range of 0.4 m.
    assert max(likelihoods[8:]) < likelihoods[0] - 20


def test_a_scan_without_a_return_tells_no_finite_lie(model: SensorModel) -> None:
    empty = Scan(0.0, BEARINGS, np.full(61, np.inf))
    found = model.log_likelihood(FIELD.free_poses(np.random.default_rng(0), 50), empty)
    assert np.isfinite(found).all()


def test_a_scan_with_one_return_is_enough(model: SensorModel) -> None:
    ranges = np.full(61, np.inf)
    ranges[30] = scan_at(TRUTH).ranges[30]
    assert math.isfinite(at(model, TRUTH, Scan(0.0, BEARINGS, ranges)))


def test_more_spread_makes_it_less_sharp(model: SensorModel) -> None:
    scan = scan_at(TRUTH)
    off = TRUTH @ Pose2(0.01, 0, 0.02)
    gaps = [
        at(model, TRUTH, replace(scan, extra_sd=sd)) - at(model, off, replace(scan, extra_sd=sd))
        for sd in (0.0, 0.005, 0.02, 0.05)
    ]
    assert gaps[0] > gaps[1] > gaps[2] > gaps[3] > 0


def test_the_same_question_gets_the_same_answer_and_changes_nothing(model: SensorModel) -> None:
    poses = FIELD.free_poses(np.random.default_rng(0), 100)
    scan = scan_at(TRUTH)
    before, ranges = poses.copy(), scan.ranges.copy()
    first = model.log_likelihood(poses, scan)
    np.testing.assert_array_equal(first, model.log_likelihood(poses, scan))
    np.testing.assert_array_equal(first[40:60], model.log_likelihood(poses[40:60], scan))
    np.testing.assert_array_equal(poses, before)
    np.testing.assert_array_equal(scan.ranges, ranges)


def test_a_full_turn_makes_no_difference(model: SensorModel) -> None:
    poses = FIELD.free_poses(np.random.default_rng(0), 100)
    scan = scan_at(TRUTH)
    turned = np.add(poses, (0, 0, 2 * math.pi))
    np.testing.assert_allclose(
        model.log_likelihood(poses, scan), model.log_likelihood(turned, scan), rtol=1e-4, atol=0.3
    )


@pytest.mark.parametrize("ahead", [0.06, -0.1])
def test_rays_may_start_elsewhere_than_at_the_robot(model: SensorModel, ahead: float) -> None:
    scan = scan_at(TRUTH, ahead=ahead)
    likelihood = at(model, TRUTH, scan)
    assert likelihood > at(model, TRUTH, replace(scan, robot_from_scan=Pose2())) + 20
    offs = np.array([[0.01, 0, 0], [-0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.03]])
    assert (model.log_likelihood(TRUTH.to_array() + offs, scan) < likelihood).all()


@pytest.mark.slow
def test_a_scanner_may_look_backwards(model: SensorModel) -> None:
    turned = scan_at(TRUTH @ Pose2(0, 0, math.pi))
    scan = Scan(0.0, BEARINGS, turned.ranges, Pose2(0, 0, math.pi))
    straight = scan_at(TRUTH, bearings=BEARINGS + math.pi)
    assert at(model, TRUTH, scan) == pytest.approx(at(model, TRUTH, straight), abs=0.05)


def test_one_false_return_costs_only_so_much(model: SensorModel) -> None:
    """Else a single disc on the floor could rule the truth out."""
    scan = scan_at(TRUTH)
    ranges = scan.ranges.copy()
    ranges[30] = 0.2
    cost = at(model, TRUTH, scan) - at(model, TRUTH, replace(scan, ranges=ranges))
    assert 1 < cost < 8


def test_a_robot_that_is_told_to_be_off_the_field_is_merely_unlikely(model: SensorModel) -> None:
    far = np.array([[5.0, 5.0, 0.0], [-100.0, 3.0, 1.0], [1e6, 0.0, 0.0]])
    found = model.log_likelihood(far, scan_at(TRUTH))
    assert np.isfinite(found).all()
    assert (found < at(model, TRUTH, scan_at(TRUTH)) - 50).all()


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_no_more_rays_count_than_are_asked_for(name: str) -> None:
    """Evenly spread: with 3 of 61 rays the first, the middle and the last."""
    scan = scan_at(TRUTH)
    few = Scan(0.0, BEARINGS[[0, 30, 60]], scan.ranges[[0, 30, 60]])
    poses = TRUTH.to_array() + np.random.default_rng(0).normal(0, 0.02, (50, 3))
    assert scan.hit.all(), "or else the models would choose among different rays"
    np.testing.assert_allclose(
        model_of(name, max_beams=3).log_likelihood(poses, scan),
        model_of(name, max_beams=60).log_likelihood(poses, few),
    )


def test_rays_are_counted_that_are_summed() -> None:
    scan = scan_at(TRUTH)
    ranges, sight = scan.ranges.copy(), np.tile([0.0, 1.0], (61, 1))
    ranges[:21] = np.inf
    sight[:11] = np.nan
    seen = replace(scan, ranges=ranges, sight=sight)
    for most, field, beam in ((61, 40, 50), (30, 30, 25)):
        for name in ("likelihood_field", "likelihood_field_prob"):
            assert count_rays(model_of(name, max_beams=most), CLOUD, seen) == field
        assert count_rays(model_of("beam", max_beams=most), CLOUD, seen) == pytest.approx(
            beam, abs=1
        )


# --- how far ranges count


CLOUD = TRUTH.to_array() + np.random.default_rng(2).normal(0, [0.004, 0.004, 0.01], (200, 3))


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_returns_from_too_near_are_left_out_and_those_from_too_far_are_none(name: str) -> None:
    scan = scan_at(TRUTH)
    low, high = np.quantile(scan.ranges[scan.hit], [0.2, 0.8])
    left = scan.ranges >= low
    seen = Scan(0.0, BEARINGS[left], np.where(scan.ranges > high, np.inf, scan.ranges)[left])
    model = model_of(name, laser_max_range=float(high), max_beams=61)
    np.testing.assert_allclose(
        model.log_likelihood(CLOUD, scan.within(low, high)), model.log_likelihood(CLOUD, seen)
    )
    assert 20 < seen.hit.sum() < 45 < len(seen.ranges)


# --- the choice


def test_the_parameters_choose_the_model_and_reach_it() -> None:
    p = replace(PARAMETERS, sigma_hit=0.01, z_hit=0.8, z_rand=0.2, max_beams=17)
    field = sensor_model(p, ENTRIES, FIELD.edges)
    assert isinstance(field, LikelihoodField)
    assert (field.sigma_hit, field.z_hit, field.z_rand, field.max_beams) == (0.01, 0.8, 0.2, 17)
    beam = beam_of(z_short=0.11, z_max=0.12, lambda_short=3.0)
    assert (beam.z_short, beam.z_max, beam.lambda_short, beam.range_max) == (0.11, 0.12, 3.0, 1.0)
    p = replace(p, laser_model_type="likelihood_field_prob", do_beamskip=True)
    p = replace(p, beam_skip_distance=0.04, beam_skip_threshold=0.2, beam_skip_error_threshold=0.7)
    skips = sensor_model(p, ENTRIES, FIELD.edges)
    assert isinstance(skips, LikelihoodFieldProb)
    assert (skips.skips, skips.skip_distance, skips.plain.max_beams) == (True, 0.04, 17)
    assert (skips.skip_threshold, skips.skip_error_threshold) == (0.2, 0.7)
