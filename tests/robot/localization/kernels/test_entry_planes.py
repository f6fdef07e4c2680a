"""A cell of the field as one word is the same distance as from its four corners."""

from __future__ import annotations

import math

import numpy as np
import pytest
from entry_reading import distance_at

from robot.geometry import Array
from robot.localization.kernels.entry_planes import planes

FARTHEST = 0.15
CELL = 0.005


def table_of(values: Array) -> np.ndarray:
    """The same for all eight directions."""
    return np.repeat(values[None], 8, axis=0).astype(np.float32)


def places(height: int, width: int, count: int = 3000) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(0)
    at = rng.random((2, count)) * [[height - 1.001], [width - 1.001]]
    return rng.integers(0, 8, count).astype(float), at[0], at[1]


@pytest.mark.parametrize("turned", np.linspace(-math.pi, math.pi, 9))
def test_along_a_straight_edge_a_word_is_right_to_30_um(turned: float) -> None:
    """With sign, wherever the edge lies, and up to the greatest distance."""
    row, column = np.mgrid[:40, :50] * CELL
    across = math.cos(turned) * (column - 0.1) + math.sin(turned) * (row - 0.1)
    words = planes(table_of(across), CELL, FARTHEST)
    direction, r, c = places(40, 50)
    exact = math.cos(turned) * (c * CELL - 0.1) + math.sin(turned) * (r * CELL - 0.1)
    found = distance_at(words, CELL, FARTHEST, (direction, r, c))
    known = np.abs(exact) < FARTHEST - 2 * CELL
    np.testing.assert_allclose(found[known], exact[known], atol=30e-6)


def test_where_the_sign_ends_corners_count_without_it() -> None:
    """Else a plane between -10 and 10 mm would make an edge where none is."""
    jumping = np.where(np.arange(20) < 10, 0.010, -0.010) * np.ones((20, 1))
    words = planes(table_of(jumping), CELL, FARTHEST)
    found = distance_at(words, CELL, FARTHEST, places(20, 20))
    np.testing.assert_allclose(np.abs(found), 0.010, atol=30e-6)


def test_the_last_row_and_column_are_as_far_as_can_be() -> None:
    """What lies off the table is cut to them."""
    words = planes(table_of(np.zeros((6, 7))), CELL, FARTHEST)
    assert words.shape == (8, 6, 7)
    last = (np.zeros(2), np.array([5.0, 2.0]), np.array([3.0, 6.0]))
    np.testing.assert_allclose(distance_at(words, CELL, FARTHEST, last), FARTHEST)


@pytest.mark.parametrize("distance", [FARTHEST, -FARTHEST, 0.0])
def test_the_extremes_fit_into_a_word(distance: float) -> None:
    words = planes(table_of(np.full((5, 5), distance)), CELL, FARTHEST)
    found = distance_at(words, CELL, FARTHEST, places(5, 5))
    np.testing.assert_allclose(found, distance, atol=20e-6)
