"""Who goes on, how many are needed, and how sharp a likelihood may be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from robot.geometry import Array
from robot.localization.particles.clusters import Cells, Clusters, find_clusters
from robot.localization.particles.resampling import (
    effective_sample_size,
    kld_sample_size,
    low_variance,
    regularize,
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


# --- spreading copies


def clusters_of(poses: Array) -> Clusters:
    return find_clusters(poses, np.full(len(poses), 1 / len(poses)), Cells(0.05, 36))


def sausage(count: int = 4000) -> Array:
    """Particles along a wall: 0.3 m one way, 2 mm the other, and slanted."""
    values = rng().normal(0, [0.3, 0.002, 0.01], (count, 3))
    turn = np.array([[math.cos(0.5), math.sin(0.5)], [-math.sin(0.5), math.cos(0.5)]])
    values[:, :2] = values[:, :2] @ turn
    return values


def one_cluster(poses: Array) -> tuple[Clusters, NDArray[np.int64]]:
    """Cells so large that all is one."""
    found = find_clusters(poses, np.full(len(poses), 1 / len(poses)), Cells(100.0, 1))
    assert len(found.hypotheses) == 1
    return found, found.labels


def test_no_scale_is_no_spread() -> None:
    poses = sausage()
    found, labels = one_cluster(poses)
    np.testing.assert_array_equal(regularize(poses, found, labels, 0.0, rng()), poses)


def test_copies_of_one_particle_are_spread_by_the_bandwidth_along_each_axis() -> None:
    """Most along the wide direction of its cluster, hardly across it."""
    found, labels = one_cluster(sausage())
    copies = np.tile(found.hypotheses[0].pose.to_array(), (4000, 1))
    spread = regularize(copies, found, labels, 1.0, rng(1)) - copies
    bandwidth = (4 / (5 * 4000)) ** (1 / 7)
    np.testing.assert_allclose(
        np.cov(spread.T), bandwidth**2 * found.hypotheses[0].covariance, rtol=0.1, atol=2e-5
    )
    across = spread[:, :2] @ (-math.sin(0.5), math.cos(0.5))
    along = spread[:, :2] @ (math.cos(0.5), math.sin(0.5))
    assert along.std() == pytest.approx(bandwidth * 0.3, rel=0.05)
    assert across.std() < 0.002


def test_fewer_copies_are_spread_wider() -> None:
    found, labels = one_cluster(sausage())
    widths = [
        regularize(np.zeros((count, 3)), found, labels[:count], 0.5, rng())[:, 0].std()
        for count in (100, 4000)
    ]
    assert widths[0] / widths[1] == pytest.approx(40 ** (1 / 7), rel=0.15)


@pytest.mark.parametrize("scale", [0.35, 1.0, 2.0])
@pytest.mark.parametrize("copied", [1, 10])
def test_the_cluster_as_a_whole_stays_as_wide_and_where_it_is(scale: float, copied: int) -> None:
    """Else, where nothing is measured, it would grow with every scan, or die out."""
    poses = sausage(20000)
    poses[:, 2] += math.pi - 0.01
    poses[:, 2] = (poses[:, 2] + math.pi) % (2 * math.pi) - math.pi
    found, labels = one_cluster(poses)
    kept = np.repeat(poses[:: 10 * copied], copied, axis=0)
    spread = regularize(kept, found, labels[: len(kept)], scale, rng(1))
    assert ((spread[:, 2] >= -math.pi) & (spread[:, 2] < math.pi)).all()
    before, after = found.hypotheses[0], one_cluster(spread)[0].hypotheses[0]
    assert after.pose.distance_to(before.pose) < 0.05
    assert abs(after.pose.turn_to(before.pose)) < 3e-3
    np.testing.assert_allclose(after.covariance, before.covariance, rtol=0.12, atol=2e-4)


def test_each_cluster_is_spread_by_its_own_width() -> None:
    wide, narrow = rng().normal(0, 0.03, (500, 3)), rng(1).normal(0, 0.001, (500, 3))
    narrow[:, 0] += 2
    poses = np.vstack([wide, narrow])
    found = clusters_of(poses)
    spread = regularize(poses, found, found.labels, 1.0, rng()) - poses
    assert spread[500:].std() < 0.1 * spread[:500].std()


def test_particles_of_no_described_cluster_and_single_ones_stay() -> None:
    poses = np.vstack([rng().normal(0, 0.01, (50, 3)), [[1.0, 1.0, 0.5]]])
    described = find_clusters(poses, np.full(51, 1 / 51), Cells(0.05, 36), most=1)
    spread = regularize(poses, described, described.labels, 1.0, rng())
    np.testing.assert_allclose(spread[-1], poses[-1], atol=1e-15)
    all_of_them = clusters_of(poses)
    spread = regularize(poses, all_of_them, all_of_them.labels, 1.0, rng())
    np.testing.assert_allclose(spread[-1], poses[-1], atol=1e-15)


def test_headings_stay_wrapped_and_the_given_poses_as_they_were() -> None:
    poses = rng().normal([0, 0, math.pi], [0.01, 0.01, 0.3], (300, 3))
    poses[:, 2] = (poses[:, 2] + math.pi) % (2 * math.pi) - math.pi
    before = poses.copy()
    found = clusters_of(poses)
    spread = regularize(poses, found, found.labels, 1.0, rng())
    assert ((spread[:, 2] >= -math.pi) & (spread[:, 2] < math.pi)).all()
    np.testing.assert_array_equal(poses, before)


def test_spreading_and_drawing_again_and_again_keeps_a_width_alive() -> None:
    """Without it only copies of a few particles are left, wherever those happen to be."""

    def drawn_often(scale: float) -> Array:
        poses, chance = rng().normal(0, 0.1, (300, 3)), rng(2)
        for _ in range(600):
            weights = normalised(list(chance.uniform(0.2, 1, 300)))
            cluster = find_clusters(poses, weights, Cells(100.0, 1))
            kept = low_variance(weights, 300, chance)
            poses = regularize(poses[kept], cluster, cluster.labels[kept], scale, chance)
        return poses

    assert len(np.unique(drawn_often(0.0), axis=0)) < 15
    spread = drawn_often(1.0)
    assert len(np.unique(spread, axis=0)) == 300
    assert (spread.std(axis=0) > 0.02).all() and (spread.std(axis=0) < 0.3).all()
