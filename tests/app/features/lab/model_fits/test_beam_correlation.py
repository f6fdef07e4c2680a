"""Rays that err together are worth as many independent ones as theory says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.features.lab.model_fits.beam_correlation import (
    BeamCorrelation,
    correlate_beams,
    correlation_time,
    independent_rays,
    initial_positive,
)
from app.features.lab.model_fits.likelihood import FitError
from app.features.lab.model_fits.range_pairs import RangePairs
from robot.geometry import Array
from robot.scan import evenly

SCANS, RAYS = 600, 91


def pairs_of(errors: Array) -> RangePairs:
    """Scans (s, r) of a wall at half a metre; nan is no return."""
    scans, rays = errors.shape
    count = scans * rays
    return RangePairs(
        np.where(np.isnan(errors), np.inf, 0.5 + errors).ravel(),
        np.full(count, 0.5),
        np.zeros(count),
        np.repeat(np.arange(scans), rays),
        np.tile(np.arange(rays), scans),
        np.ones(count, dtype=bool),
        np.tile([0.0, 1.0], (count, 1)),
    )


def smooth(rng: np.random.Generator, shape: tuple[int, int], phi: float) -> Array:
    """AR(1) along each row: correlation phi to the power of the lag, variance 1."""
    errors = rng.standard_normal(shape)
    for k in range(1, shape[1]):
        errors[:, k] = phi * errors[:, k - 1] + math.sqrt(1 - phi**2) * errors[:, k]
    return errors


def correlate(errors: Array, beams: int = 60, **more: int) -> BeamCorrelation:
    return correlate_beams(pairs_of(1e-3 * errors), beams, resamples=100, **more)


def worth(phi: float, used: Array) -> float:
    return len(used) ** 2 / float((phi ** np.abs(used[:, None] - used)).sum())


# --- exact


def test_correlations_are_those_counted_by_hand() -> None:
    """Of ten like scans, with one ray that returned nothing."""
    row = np.array([1.0, 3.0, np.nan, -2.0, -2.0])
    found = correlate(np.tile(row, (10, 1)))
    variance = (1 + 9 + 4 + 4) / 4
    products = [variance, (3 + 4) / 2, -6.0, (-2 - 6) / 2, -2.0]
    np.testing.assert_allclose(found.by_ray, np.array(products) / variance)
    np.testing.assert_allclose(found.by_scan, 1.0)


def test_a_known_correlation_gives_the_known_number_of_rays() -> None:
    lags = np.arange(91)
    for used in (evenly(91, 60), evenly(91, 91), evenly(91, 10)):
        assert independent_rays(0.8**lags, used) == pytest.approx(worth(0.8, used), rel=1e-6)
    n, rho = 91, 0.8 ** lags[1:]
    formula = n / (1 + 2 * ((1 - lags[1:] / n) * rho).sum())
    assert independent_rays(0.8**lags, evenly(91, 91)) == pytest.approx(formula, rel=1e-6)
    assert correlation_time(0.5 ** np.arange(60)) == pytest.approx(3)


def test_the_sum_ends_where_correlation_is_chance() -> None:
    found = initial_positive(np.array([1.0, 0.4, 0.2, -0.1, 0.1, -0.2, 0.9, 0.9]))
    assert found.tolist() == [1.0, 0.4, 0.2, -0.1]
    assert initial_positive(np.array([1.0, 0.5, np.nan, 0.9])).tolist() == [1.0, 0.5]


# --- drawn


@pytest.mark.parametrize("phi", [0.0, 0.5, 0.9])
def test_rays_of_a_known_process_are_worth_what_theory_says(phi: float) -> None:
    found = correlate(smooth(np.random.default_rng(0), (2000, RAYS), phi))
    true = worth(phi, evenly(RAYS, 60))
    assert found.rays_worth == pytest.approx(true, rel=0.05)
    assert found.likelihood_weight == pytest.approx(true / 60, rel=0.05)
    np.testing.assert_allclose(found.by_ray[:8], phi ** np.arange(8.0), atol=0.03)
    assert found.scans_a_new_one == pytest.approx(1, abs=0.1)


def test_missing_rays_change_nothing_but_the_luck() -> None:
    rng = np.random.default_rng(1)
    errors = smooth(rng, (SCANS, RAYS), 0.8)
    errors[rng.random(errors.shape) < 0.4] = np.nan
    assert correlate(errors).rays_worth == pytest.approx(worth(0.8, evenly(RAYS, 60)), rel=0.05)


def test_successive_scans_that_err_together_are_worth_fewer() -> None:
    rng = np.random.default_rng(2)
    errors = smooth(rng, (RAYS, SCANS), 0.6).T
    found = correlate(errors)
    assert found.scans_a_new_one == pytest.approx(1.6 / 0.4, rel=0.1)
    assert found.likelihood_weight_of_successive_scans == pytest.approx(0.25, rel=0.12)
    assert found.likelihood_weight > 0.9


def test_what_a_whole_scan_is_off_by_is_what_its_rays_are_off_by_together() -> None:
    """The mean is that of all scans: half of the variance is the scan's own."""
    rng = np.random.default_rng(3)
    errors = rng.standard_normal((SCANS, RAYS)) + rng.standard_normal((SCANS, 1)) + 5
    found = correlate(errors)
    np.testing.assert_allclose(found.by_ray[1:], 0.5, atol=0.06)
    assert found.rays_worth < 2.1


def test_one_wild_return_does_not_hide_what_the_others_share() -> None:
    errors = smooth(np.random.default_rng(4), (SCANS, RAYS), 0.9)
    errors[::7, 50] = 25.0
    assert correlate(errors).by_ray[1] == pytest.approx(0.9, abs=0.02)


def test_intervals_hold_the_truth_and_repeat_with_the_seed() -> None:
    true = worth(0.8, evenly(RAYS, 60))
    inside = 0
    for seed in range(20):
        found = correlate(smooth(np.random.default_rng(seed), (100, RAYS), 0.8))
        low, high = found.rays_worth_interval
        inside += low <= true <= high
    assert inside >= 17
    again, other = (
        correlate(smooth(np.random.default_rng(19), (100, RAYS), 0.8), seed=seed) for seed in (0, 1)
    )
    assert again.rays_worth_interval == found.rays_worth_interval
    assert other.rays_worth_interval != found.rays_worth_interval


def test_what_has_no_correlation_is_refused() -> None:
    with pytest.raises(FitError, match="9 scans"):
        correlate(np.random.default_rng(0).standard_normal((9, 20)))
    with pytest.raises(FitError, match="at most 0 returns"):
        correlate(np.full((20, 20), np.nan))
    with pytest.raises(FitError, match="off by the same"):
        correlate(np.full((20, 20), 1.0))
