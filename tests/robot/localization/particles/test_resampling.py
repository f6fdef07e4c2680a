"""Who goes on, how many are needed, and how sharp a likelihood may be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.geometry import Array
from robot.localization.particles.resampling import (
    effective_sample_size,
    kld_sample_size,
    low_variance,
    temper,
)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


masses = st.lists(
    st.one_of(st.just(0.0), st.floats(1e-9, 1.0)), min_size=1, max_size=50
).filter(lambda values: sum(values) > 0)  # fmt: skip


def normalised(values: list[float]) -> Array:
    return np.array(values) / sum(values)


# --- low-variance resampling


@given(masses, st.integers(1, 300), st.integers(0, 2**32 - 1))
def test_a_particle_is_drawn_by_its_weight_rounded_down_or_up(
    values: list[float], count: int, seed: int
) -> None:
    weights = normalised(values)
    drawn = low_variance(weights, count, rng(seed))
    assert drawn.shape == (count,)
    times = np.bincount(drawn, minlength=len(weights))
    assert (times >= np.floor(count * weights - 1e-9)).all()
    assert (times <= np.ceil(count * weights + 1e-9)).all()
    assert (times[weights == 0] == 0).all()


def test_drawn_often_each_particle_gets_its_share() -> None:
    weights = normalised([1, 2, 3, 0.5, 0, 0.01])
    chance = rng()
    total = sum(np.bincount(low_variance(weights, 7, chance), minlength=6) for _ in range(4000))
    np.testing.assert_allclose(total / 28000, weights, atol=3e-3)


@pytest.mark.parametrize("place", [0, 1, 99])
def test_a_particle_with_all_the_weight_is_drawn_every_time(place: int) -> None:
    weights = np.zeros(100)
    weights[place] = 1
    assert (low_variance(weights, 50, rng()) == place).all()


def test_even_weights_keep_every_particle_once() -> None:
    drawn = low_variance(np.full(64, 1 / 64), 64, rng())
    np.testing.assert_array_equal(np.sort(drawn), np.arange(64))


class _AlwaysLast(np.random.Generator):
    """The highest number below one."""

    def __init__(self) -> None:
        super().__init__(np.random.PCG64(0))

    def random(self, *_: object, **__: object) -> float:  # type: ignore[override]
        return math.nextafter(1.0, 0.0)


def test_rounding_never_draws_past_the_last_particle() -> None:
    weights = np.full(7, 1 / 7)  # their sum is a little below one
    drawn = low_variance(weights, 100_000, _AlwaysLast())
    assert drawn.max() == 6 and drawn.min() == 0


# --- effective sample size


@given(masses)
def test_the_effective_sample_size_is_between_one_and_all(values: list[float]) -> None:
    size = effective_sample_size(normalised(values))
    assert 1 - 1e-9 <= size <= len(values) + 1e-9


def test_the_effective_sample_size_of_even_weights_is_their_number() -> None:
    assert effective_sample_size(np.full(40, 1 / 40)) == pytest.approx(40)
    assert effective_sample_size(np.array([0.0, 1.0, 0.0])) == 1
    assert effective_sample_size(np.array([0.5, 0.5, 0.0])) == pytest.approx(2)


# --- how many particles are needed


@pytest.mark.parametrize(
    ("bins", "pf_err", "pf_z", "needed"),
    [
        # (k - 1) / (2 e) (1 - 2 / (9 (k - 1)) + sqrt(2 / (9 (k - 1))) z)^3, worked out by hand
        (2, 0.05, 0.99, 20),
        (10, 0.05, 0.99, 131),
        (100, 0.05, 0.99, 1129),
        (100, 0.01, 2.33, 6736),
        (2, 0.05, 0.0, 5),
        (0, 0.05, 0.99, 1),
        (1, 0.05, 0.99, 1),
    ],
)
def test_the_number_of_particles_is_that_of_the_formula(
    bins: int, pf_err: float, pf_z: float, needed: int
) -> None:
    assert kld_sample_size(bins, pf_err, pf_z) == needed


def test_it_is_half_the_quantile_of_chi_squared_by_the_error() -> None:
    """What the formula (Wilson and Hilferty 1931) stands for."""
    from scipy.stats import chi2, norm

    for bins in (5, 20, 200):
        exact = chi2.ppf(norm.cdf(2.0), bins - 1) / (2 * 0.05)
        assert kld_sample_size(bins, 0.05, 2.0) == pytest.approx(exact, rel=0.01, abs=1)


@given(st.integers(0, 3000), st.floats(0.001, 1), st.floats(0, 5))
def test_more_cells_smaller_errors_and_surer_bounds_need_more(
    bins: int, pf_err: float, pf_z: float
) -> None:
    needed = kld_sample_size(bins, pf_err, pf_z)
    assert needed >= 1
    assert kld_sample_size(bins + 1, pf_err, pf_z) >= needed
    assert kld_sample_size(bins, pf_err * 0.9, pf_z) >= needed
    assert kld_sample_size(bins, pf_err, pf_z + 0.1) >= needed


# --- weighing


@given(
    st.lists(st.tuples(st.floats(-400, 50), st.floats(1e-6, 1)), min_size=2, max_size=60),
    st.floats(0.01, 1),
    st.floats(0, 0.9),
)
def test_the_new_weights_keep_their_order_and_enough_of_them_count(
    pairs: list[tuple[float, float]], exponent: float, share: float
) -> None:
    log_likelihood, mass = np.array(pairs).T
    even = np.full(len(mass), 1 / len(mass))
    least = share * len(mass)
    new = temper(log_likelihood, even, exponent, least)
    assert new.sum() == pytest.approx(1)
    assert effective_sample_size(new) >= min(least, len(mass)) - 1e-6
    order = np.argsort(log_likelihood)
    assert (np.diff(new[order]) >= -1e-15).all()


def test_a_likelihood_that_is_not_too_sharp_counts_in_full() -> None:
    log_likelihood = np.array([0.0, -1.0, -2.0])
    weights = normalised([1, 2, 1])
    expected = weights * np.exp(0.5 * log_likelihood)
    found = temper(log_likelihood, weights, 0.5, 1.0)
    np.testing.assert_allclose(found, expected / expected.sum())


def test_a_likelihood_that_is_too_sharp_counts_as_much_as_it_may() -> None:
    log_likelihood = -1e4 * np.linspace(0, 1, 100)
    found = temper(log_likelihood, np.full(100, 0.01), 1.0, 20.0)
    assert 20 <= effective_sample_size(found) < 20.5


def test_a_constant_makes_no_difference_to_a_likelihood() -> None:
    log_likelihood, weights = rng().normal(0, 3, 50), normalised(list(rng(1).random(50)))
    plain = temper(log_likelihood, weights, 0.3, 5.0)
    for constant in (-1e5, 700.0, 1e5):
        moved = temper(log_likelihood + constant, weights, 0.3, 5.0)
        np.testing.assert_allclose(moved, plain, rtol=1e-6)


def test_what_weighs_nothing_goes_on_weighing_nothing_however_likely() -> None:
    """The best particle has no weight, and all the others are far less likely."""
    log_likelihood = np.array([5000.0, -10.0, -11.0, -5000.0])
    found = temper(log_likelihood, np.array([0.0, 0.5, 0.3, 0.2]), 1.0, 1.0)
    assert np.isfinite(found).all()
    assert found[0] == 0
    expected = np.array([0.5, 0.3 * math.exp(-1)])
    np.testing.assert_allclose(found[1:3], expected / expected.sum(), rtol=1e-6)
