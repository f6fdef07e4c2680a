"""The beam model is its book's formula, number by number, and knows what it should see."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sensor_trials import (
    BEARINGS,
    FIELD,
    PARAMETERS,
    TRUTH,
    at,
    beam_of,
    scan_at,
)

from robot.fields.edge_index import index_edges
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, Pose2, compose
from robot.localization.models.beam import MISSED_AT_END, MISSED_AT_START
from robot.scan import Scan

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
    assert sees(0.1, 0.5 + MISSED_AT_END / 2, math.inf, 0.5) == 0, "so near the end of sight"
    assert sees(0.5 - MISSED_AT_START / 2, 0.65, math.inf, 0.5) == 0, "or its begin"
    assert sees(math.nan, math.nan, 0.5, 0.5) == 0, "a ray that sees nothing says nothing"


def test_an_edge_below_the_view_hides_nothing() -> None:
    """The camera sees over tape that lies between it and where its view begins."""
    assert sees(0.1, 0.8, 0.7, 0.05) == pytest.approx(beam_likelihood(0.7, 0.7))
    assert sees(0.1, 0.8, 0.7, 0.05) > sees(0.0, 0.8, 0.7, 0.05) + 3


# --- few edges are looked at in another way than many


SIGHTS = st.sampled_from([None, np.tile([0.1, 0.6], (61, 1))])


@given(st.integers(0, 2**32 - 1), SIGHTS, st.booleans())
def test_it_is_the_same_however_edges_are_sorted(
    seed: int, sight: Array | None, near: bool
) -> None:
    """All at once in one cell, or walking from cell to cell."""
    rng = np.random.default_rng(seed)
    width = 0.01 if near else 0.8
    poses = TRUTH.to_array() + rng.uniform(-width, width, (20, 3))
    scan = replace(scan_at(TRUTH), sight=sight)
    one, many = (
        replace(BEAM, edges=index_edges(FIELD.edges, cell)).log_likelihood(poses, scan)
        for cell in (100.0, 0.1)
    )
    np.testing.assert_allclose(one, many, rtol=1e-9)
