"""Noise in bulk is normal, independent, and the same for the same seed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit
from scipy.stats import kstest, norm

from robot.geometry import Array, wrap_angle
from robot.localization.kernels.sampling import noise_key, normal_rows
from robot.localization.kernels.steps import heading_vector, wrapped


def normal_noise(rng: np.random.Generator, rows: int, count: int) -> Array:
    return normal_rows(noise_key(rng), rows, count)[:, :count]


def noise(seed: int, rows: int = 3, count: int = 40_000) -> Array:
    return normal_noise(np.random.default_rng(seed), rows, count).astype(np.float64)


@pytest.mark.parametrize("seed", range(5))
def test_each_row_is_standard_normal_into_its_tails(seed: int) -> None:
    for row in noise(seed):
        assert kstest(row, norm.cdf).pvalue > 1e-4
    drawn = noise(seed, 3, 400_000)
    for limit in (1.0, 2.0, 3.0, 4.0):
        expected = 2 * norm.sf(limit) * drawn.size
        assert abs((np.abs(drawn) > limit).sum() - expected) < 5 * math.sqrt(expected)


def test_rows_neighbours_and_calls_have_nothing_to_do_with_one_another() -> None:
    rng = np.random.default_rng(0)
    first, second = (normal_noise(rng, 4, 100_000).astype(float) for _ in range(2))
    rows = np.vstack([first, second, first[:, ::-1], np.roll(first, 1, axis=1)])
    for values in (rows, rows**2):
        assert np.abs(np.corrcoef(values) - np.eye(16)).max() < 0.02


@pytest.mark.parametrize("count", [0, 1, 2, 7, 500])
def test_any_count_is_possible(count: int) -> None:
    drawn = normal_noise(np.random.default_rng(0), 3, count)
    assert drawn.shape == (3, count)
    assert np.isfinite(drawn).all()


def test_the_same_seed_gives_the_same_and_the_generator_goes_on() -> None:
    np.testing.assert_array_equal(noise(3), noise(3))
    rng = np.random.default_rng(3)
    assert not np.array_equal(normal_noise(rng, 3, 9), normal_noise(rng, 3, 9))


@njit
def _each(angles: Array) -> Array:
    result = np.empty((3, len(angles)))
    for i in range(len(angles)):
        result[0, i], result[1, i] = heading_vector(angles[i])
        result[2, i] = wrapped(angles[i])
    return result


def test_compiled_headings_are_those_of_the_library() -> None:
    angles = np.concatenate([np.linspace(-50, 50, 20_001), np.arange(-8, 9) * math.pi / 2])
    cosine, sine, inside = _each(angles)
    np.testing.assert_allclose(cosine, np.cos(angles), atol=1e-12)
    np.testing.assert_allclose(sine, np.sin(angles), atol=1e-12)
    assert ((inside >= -math.pi) & (inside < math.pi)).all()
    np.testing.assert_allclose(wrap_angle(inside - wrap_angle(angles) + 1.0), 1.0, atol=1e-12)
