"""Every sensor model likes the truth best; each is its book's formula, number by number."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from robot.fields.edge_index import index_edges
from robot.fields.edges import normals
from robot.fields.field_loading import load_field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, compose, heading_vectors, wrap_angle
from robot.localization.models.beam import SIGHT_MARGIN, Beam
from robot.localization.models.entry_field import EntryField
from robot.localization.models.likelihood_field import LikelihoodField
from robot.localization.models.likelihood_field_prob import LikelihoodFieldProb
from robot.localization.models.sensor_models import SensorModel, sensor_model
from robot.localization.parameters import SENSOR_MODELS, SensorParameters
from robot.scan import Scan

FIELD = load_field("stub", Path(__file__).parent.parent / "maps")
PARAMETERS = SensorParameters()
ENTRIES = EntryField.build(
    FIELD,
    resolution=PARAMETERS.field_resolution,
    max_distance=PARAMETERS.laser_likelihood_max_dist,
)
BEARINGS = np.radians(np.linspace(-31, 31, 61))


def model_of(name: str, **changes: Any) -> SensorModel:
    parameters = replace(PARAMETERS, laser_model_type=name, **changes)
    return sensor_model(parameters, ENTRIES, FIELD.edges)


def beam_of(**changes: Any) -> Beam:
    made = sensor_model(
        replace(PARAMETERS, laser_model_type="beam", **changes), ENTRIES, FIELD.edges
    )
    assert isinstance(made.model, Beam)
    return made.model


def scan_at(
    pose: Pose2, *, ahead: float = 0.0, sd: float = 0.0, bearings: Array = BEARINGS
) -> Scan:
    """The scan that a perfect scanner (or one with noise [m]) makes at a pose."""
    ranges = np.empty((1, len(bearings)))
    start = pose @ Pose2(ahead)
    reach = PARAMETERS.laser_max_range
    cast_rays(start.to_array()[None], bearings, FIELD.edge_index, reach, ranges)
    noise = sd * np.random.default_rng(1).standard_normal(len(bearings))
    return Scan(0.0, bearings, ranges[0] + noise, Pose2(ahead))


def at(model: SensorModel, pose: Pose2, scan: Scan) -> float:
    return float(model.log_likelihood(pose.to_array()[None], scan)[0])


TRUTH = Pose2(0.1, -0.15, 0.4)


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
    assert max(likelihoods[6:]) < likelihoods[0] - 20


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


# --- the likelihood field


def entry_distances(ends: Array, headings: Array) -> Array:
    """By shapely: from each end the way to the nearest edge that its ray can enter by."""
    found = []
    facing_from = normals(FIELD.edges)
    for end, heading in zip(ends, headings, strict=True):
        toward = heading_vectors(np.array([round(heading / (math.pi / 4)) * math.pi / 4]))[0]
        facing = facing_from @ toward < math.sin(math.pi / 8)
        lines = shapely.linestrings(FIELD.edges[facing].reshape(-1, 2, 2))
        found.append(shapely.distance(lines, shapely.points(end)).min())
    return np.minimum(found, PARAMETERS.laser_likelihood_max_dist)


@pytest.mark.parametrize("extra_sd", [0.0, 0.01])
def test_the_likelihood_field_is_the_books_formula(extra_sd: float) -> None:
    """Table 6.3, over exact distances to the edges; the table's cells may blur it a little."""
    p = replace(PARAMETERS, sigma_hit=0.02, max_beams=61)
    model = sensor_model(p, ENTRIES, FIELD.edges)
    scan = replace(scan_at(TRUTH), extra_sd=extra_sd)
    poses = TRUTH.to_array() + np.random.default_rng(0).normal(0, [0.02, 0.02, 0.05], (30, 3))
    sd = math.hypot(0.02, extra_sd)
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


# --- the beam model


BEAM = beam_of()


def beam_likelihood(z: float, expected: float, extra_sd: float = 0.0) -> float:
    """Of one ray, by the beam model, in front of a wall at a distance [m]; inf is none."""
    wall = np.array([[expected, 9.0, expected, -9.0]]) if math.isfinite(expected) else FAR_AWAY
    model = replace(BEAM, edges=index_edges(wall))
    return at(model, Pose2(), Scan(0.0, np.zeros(1), np.array([z]), extra_sd=extra_sd))


FAR_AWAY = np.array([[-50.0, 0.0, -50.0, 1.0]])


@pytest.mark.parametrize("z", [0.1, 0.4, 0.497, 0.5, 0.503, 0.7])
@pytest.mark.parametrize("extra_sd", [0.0, 0.01])
def test_the_beam_model_is_the_books_formula(z: float, extra_sd: float) -> None:
    """Table 6.1, for a wall at 0.5 m."""
    p, sd = PARAMETERS, math.hypot(PARAMETERS.sigma_hit, extra_sd)
    hit = math.exp(-((z - 0.5) ** 2) / (2 * sd**2)) / (sd * math.sqrt(2 * math.pi))
    short = p.lambda_short * math.exp(-p.lambda_short * z) if z <= 0.5 else 0.0
    expected = p.z_hit * hit + p.z_short * short + p.z_rand / p.laser_max_range
    assert beam_likelihood(z, 0.5, extra_sd) == pytest.approx(math.log(expected))


def test_a_ray_that_should_have_returned_and_did_not_speaks_against_a_pose() -> None:
    assert beam_likelihood(math.inf, 0.5) == pytest.approx(math.log(PARAMETERS.z_max))
    assert beam_likelihood(math.inf, math.inf) == 0
    assert beam_likelihood(math.inf, 1.5) == 0, "beyond its range nothing is expected"


def test_a_return_where_the_map_has_nothing_is_clutter() -> None:
    p = PARAMETERS
    clutter = p.z_short * p.lambda_short * math.exp(-p.lambda_short * 0.3) + p.z_rand
    assert beam_likelihood(0.3, math.inf) == pytest.approx(math.log(clutter))


def test_the_beam_knows_that_an_edge_hides_what_lies_behind() -> None:
    """From behind the wall in front, a scan of the far wall is unlikely; the field cannot say."""
    near, far = np.array([[0.3, 9, 0.3, -9]]), np.array([[0.6, 9.0, 0.6, -9]])
    scan = Scan(0.0, np.linspace(-0.2, 0.2, 9), 0.6 / np.cos(np.linspace(-0.2, 0.2, 9)))
    open_view, hidden = (
        at(replace(BEAM, edges=index_edges(edges)), Pose2(), scan)
        for edges in (far, np.vstack([near, far]))
    )
    assert hidden < open_view - 30


@pytest.mark.parametrize("extra_sd", [0.0, 0.01])
def test_a_scan_is_the_product_of_its_rays(extra_sd: float) -> None:
    """At any pose, on the tape and off the field too."""
    rng = np.random.default_rng(0)
    poses = rng.uniform([-0.7, -0.7, -math.pi], [0.7, 0.7, math.pi], (60, 3))
    ranges = np.where(rng.random(61) < 0.2, np.inf, rng.uniform(0.05, 0.9, 61))
    start = Pose2(0.06, 0.01, 0.2)
    scan = Scan(0.0, BEARINGS, ranges, start, extra_sd=extra_sd)
    p, sd = PARAMETERS, math.hypot(PARAMETERS.sigma_hit, extra_sd)
    z = np.empty((60, 61))
    starts = compose(poses, start.to_array())
    cast_rays(starts, BEARINGS, FIELD.edge_index, p.laser_max_range, z)
    with np.errstate(invalid="ignore"):
        hit = np.exp(-0.5 * np.square((ranges - z) / sd)) / (sd * math.sqrt(2 * math.pi))
    short = np.where(ranges <= z, p.lambda_short * np.exp(-p.lambda_short * ranges), 0)
    seen = p.z_hit * np.where(np.isfinite(z), hit, 0) + p.z_short * short + p.z_rand
    unseen = np.where(np.isfinite(z), p.z_max, 1)
    expected = np.log(np.where(np.isfinite(ranges), seen, unseen)).sum(axis=1)
    found = beam_of(max_beams=61).log_likelihood(poses, scan)
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize(
    "scale", [{"z_rand": 0.001, "laser_max_range": 100.0}, {"sigma_hit": 5e-4}]
)
def test_many_rays_that_fit_ill_or_well_stay_within_the_range_of_numbers(
    scale: dict[str, float],
) -> None:
    bearings = np.linspace(-0.5, 0.5, 720)
    scan = scan_at(TRUTH, bearings=bearings)
    beam = beam_of(max_beams=720, z_short=0.0, **scale)
    one_by_one = [at(beam, TRUTH, Scan(0.0, bearings[[j]], scan.ranges[[j]])) for j in range(720)]
    assert at(beam, TRUTH, scan) == pytest.approx(sum(one_by_one))
    assert math.isfinite(at(beam, Pose2(3, 3), scan))


def sees(near: float, far: float, z: float, expected: float) -> float:
    """As ``beam_likelihood``, of a ray that can see from and to a distance [m]."""
    sight = np.array([[near, far]])
    wall = index_edges(np.array([[expected, 9.0, expected, -9.0], [0.7, 9.0, 0.7, -9.0]]))
    scan = Scan(0.0, np.zeros(1), np.array([z]), sight=sight)
    return at(replace(BEAM, edges=wall), Pose2(), scan)


def test_an_edge_out_of_sight_is_not_missed() -> None:
    missed = pytest.approx(math.log(PARAMETERS.z_max))
    assert sees(0.1, 0.6, math.inf, 0.5) == missed
    assert sees(0.1, 0.45, math.inf, 0.5) == 0
    assert sees(0.1, 0.5 + SIGHT_MARGIN / 2, math.inf, 0.5) == 0, "so near the end of sight"
    assert sees(0.5 - SIGHT_MARGIN / 2, 0.65, math.inf, 0.5) == 0, "or its begin"
    assert sees(math.nan, math.nan, 0.5, 0.5) == 0, "a ray that sees nothing says nothing"


def test_an_edge_below_the_view_hides_nothing() -> None:
    """The camera sees over tape that lies between it and where its view begins."""
    assert sees(0.1, 0.8, 0.7, 0.05) == pytest.approx(beam_likelihood(0.7, 0.7))
    assert sees(0.1, 0.8, 0.7, 0.05) > sees(0.0, 0.8, 0.7, 0.05) + 3


# --- the likelihood field with beam skipping


def skipping(**changes: Any) -> LikelihoodFieldProb:
    fixed = {"do_beamskip": True, "beam_skip_distance": 0.02, "sigma_hit": 0.01, "max_beams": 61}
    given = {**fixed, **changes}
    parameters = replace(PARAMETERS, laser_model_type="likelihood_field_prob", **given)
    made = sensor_model(parameters, ENTRIES, FIELD.edges).model
    assert isinstance(made, LikelihoodFieldProb)
    return made


PLAIN = model_of("likelihood_field", sigma_hit=0.01, max_beams=61)
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


# --- how far ranges count


@pytest.mark.parametrize("name", SENSOR_MODELS)
def test_returns_from_too_near_are_left_out_and_those_from_too_far_are_none(name: str) -> None:
    scan = scan_at(TRUTH)
    low, high = np.quantile(scan.ranges[scan.hit], [0.2, 0.8])
    limited = model_of(name, laser_min_range=float(low), laser_max_range=float(high), max_beams=61)
    left = scan.ranges >= low
    seen = Scan(0.0, BEARINGS[left], np.where(scan.ranges > high, np.inf, scan.ranges)[left])
    free = model_of(name, laser_max_range=float(high), max_beams=61)
    np.testing.assert_array_equal(
        limited.log_likelihood(NEAR, scan), free.log_likelihood(NEAR, seen)
    )
    assert 20 < seen.hit.sum() < 45 < len(seen.ranges)


# --- the choice


def test_the_parameters_choose_the_model_and_reach_it() -> None:
    p = replace(PARAMETERS, sigma_hit=0.01, z_hit=0.8, z_rand=0.2, max_beams=17)
    field = sensor_model(p, ENTRIES, FIELD.edges).model
    assert isinstance(field, LikelihoodField)
    assert (field.sigma_hit, field.z_hit, field.z_rand, field.max_beams) == (0.01, 0.8, 0.2, 17)
    beam = beam_of(z_short=0.11, z_max=0.12, lambda_short=3.0)
    assert (beam.z_short, beam.z_max, beam.lambda_short, beam.range_max) == (0.11, 0.12, 3.0, 1.0)
    skips = skipping(
        beam_skip_distance=0.04, beam_skip_threshold=0.2, beam_skip_error_threshold=0.7
    )
    assert (skips.skips, skips.skip_distance, skips.plain.max_beams) == (True, 0.04, 61)
    assert (skips.skip_threshold, skips.skip_error_threshold) == (0.2, 0.7)
