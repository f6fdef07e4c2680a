"""From places along a ray to metres, and back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot.scanning.along_rays import between, points_of, ranges_of, unskew

DISTANCES = np.tile(80.0 / (400 - np.arange(200.0)), (2, 1))
"""Two rays whose samples lie ever farther apart, as those of a camera do."""

DIRECTIONS = np.array([[1.0, 0.0], [0.6, 0.8]])


@given(st.floats(0, 10), st.floats(-1, 1), st.floats(-1, 1), st.floats(0, 7))
def test_between_samples_a_parabola_is_met(a: float, b: float, c: float, at: float) -> None:
    place = np.arange(8.0)
    exact = a + b * at + c * at * at
    assert between(a + b * place + c * place * place, at) == pytest.approx(exact, abs=1e-9)


def test_pairs_become_points_on_their_ray() -> None:
    edges = np.full((2, 3, 2), np.nan)
    edges[:, 0] = 50, 60.5
    points = points_of(edges, DISTANCES, DIRECTIONS)
    entry, leave = 80 / 350, 80 / 339.5
    expected = [0.6 * entry, 0.8 * entry, 0.6 * leave, 0.8 * leave]
    np.testing.assert_allclose(points[1, 0], expected, atol=1e-6)
    assert np.isnan(points[:, 1:]).all()


def test_a_range_ends_on_the_line_and_its_entry_is_moved_there() -> None:
    pairs = np.full((2, 1, 2), np.nan)
    pairs[:, 0] = 100, 120
    lines = np.array([[-1.0, 0.0, -0.27], [-1.0, 0.0, -0.27]])
    verdicts = np.array([0, 3], dtype=np.int8)
    chosen = np.zeros(2, dtype=np.int8)
    ranges, edges = ranges_of(lines, pairs, chosen, verdicts, DISTANCES, DIRECTIONS)
    assert ranges[0] == pytest.approx(0.27)
    assert between(DISTANCES[0], edges[0, 0]) == pytest.approx(0.27, abs=1e-9)
    assert ranges[1] == np.inf
    assert edges[1].tolist() == [100, 120] and edges[0, 1] == 120


@pytest.mark.parametrize(
    "line",
    [(0.0, 1.0, 0.2), (-1e-9, 1.0, 0.2), (-1.0, 0.0, -7.0), (-1.0, 0.0, 0.1), (-1.0, 0.0, -0.01)],
    ids=["along the ray", "all but along it", "far beyond", "behind the robot", "before its start"],
)
def test_a_ray_that_meets_its_line_out_of_sight_has_no_range(line: tuple[float, ...]) -> None:
    """Clutter made such a line once, and the division by zero stopped the robot."""
    pairs = np.array([[[100.0, 120.0]]])
    none = np.zeros(1, dtype=np.int8)
    ranges, edges = ranges_of(np.array([line]), pairs, none, none, DISTANCES[:1], DIRECTIONS[:1])
    assert ranges.tolist() == [np.inf]
    assert edges.tolist() == [[100, 120]]


@given(st.tuples(*[st.floats(-1, 1)] * 2, st.floats(-9, 9)), st.floats(0, 199))
def test_whatever_the_line_a_range_is_on_the_ray_or_none(
    line: tuple[float, ...], entry: float
) -> None:
    pairs = np.array([[[entry, entry]]])
    none = np.zeros(1, dtype=np.int8)
    ranges, _ = ranges_of(np.array([line]), pairs, none, none, DISTANCES[:1], DIRECTIONS[:1])
    assert ranges[0] == np.inf or 0 < ranges[0] < 2 * DISTANCES[0, -1]


def test_what_was_exposed_late_is_moved_by_what_the_robot_drove() -> None:
    """Ahead an edge at a slant of 45 degrees: driving 1 mm brings it 1 mm nearer along the ray."""
    slanted = np.array([[-np.sqrt(0.5), -np.sqrt(0.5), -0.3 * np.sqrt(0.5)]])
    late = np.tile(1e-4 * (479 - np.arange(200.0) - 239.5), (1, 1))
    ranges = np.array([0.3])
    edges = np.array([[100.0, 120.0]])
    sight = np.array([[0.1, 0.5]])
    unskew(ranges, sight, slanted, edges, late, DIRECTIONS[:1], 0.0, 0.2, 0.0)
    assert ranges[0] == pytest.approx(0.3 + 0.2 * 1e-4 * (379 - 239.5))
    # Its sight begins in the lowest row, which is exposed last, and ends in a higher one.
    ends = 1e-4 * (np.array([479, 280]) - 239.5)
    np.testing.assert_allclose(sight[0], [0.1, 0.5] + 0.2 * ends)
    unskew(ranges, sight, slanted, edges, late, DIRECTIONS[:1], 0.0, -0.2, 0.0)
    assert ranges[0] == pytest.approx(0.3)
    np.testing.assert_allclose(sight[0], [0.1, 0.5])


def test_a_turn_about_the_start_of_the_rays_moves_no_sight_and_what_is_unseen_stays_so() -> None:
    late = np.tile(1e-4 * (479 - np.arange(200.0) - 239.5), (2, 1))
    lines, edges = np.tile([-1.0, 0.0, -0.3], (2, 1)), np.full((2, 2), 100.0)
    sight = np.array([[0.1, 0.5], [np.nan, np.nan]])
    before = sight.copy()
    ranges = np.full(2, np.inf)
    unskew(ranges, sight, lines, edges, late, DIRECTIONS[:2], 0.0, 0.0, 2.0)
    np.testing.assert_allclose(sight, before, rtol=1e-12)


@pytest.mark.parametrize("omega", [2.0, -2.0])
def test_where_an_edge_ends_the_ray_that_looks_past_it_by_then_does_not_count(
    omega: float,
) -> None:
    """Two edges meet between the third and the fourth of six rays, which see the upper rows."""
    bearings = np.radians(np.arange(6.0))
    directions = np.column_stack([np.cos(bearings), np.sin(bearings)])
    normals = np.array([[-1.0, 0.0]] * 3 + [[-0.6, -0.8]] * 3)
    lines = np.column_stack([normals, [-0.4] * 3 + [-0.262] * 3])
    seen = lines[:, 2] / np.einsum("ij,ij->i", normals, directions)
    ranges = seen.copy()
    late = np.full((6, 200), -1e-4 * 80.0)
    edges = np.tile([100.0, 120.0], (6, 1))
    sight = np.tile([0.1, 0.9], (6, 1))
    unskew(ranges, sight, lines, edges, late, directions, 0.0, 0.0, omega)
    # Rows above the middle are exposed earlier, and the robot has turned by 0.9 degrees since then.
    past = 2 if omega > 0 else 3
    assert np.flatnonzero(np.isinf(ranges)).tolist() == [past]
    moved = seen - 1e-4 * 80.0 * omega * seen * np.einsum(
        "ij,ij->i", normals, np.column_stack([-directions[:, 1], directions[:, 0]])
    ) / np.einsum("ij,ij->i", normals, directions)
    kept = np.isfinite(ranges)
    np.testing.assert_allclose(ranges[kept], moved[kept], atol=1e-9)


def test_a_robot_that_hardly_turns_keeps_the_last_rays_on_an_edge() -> None:
    bearings = np.radians(np.arange(3.0))
    directions = np.column_stack([np.cos(bearings), np.sin(bearings)])
    ranges = np.array([np.inf, 0.4, np.inf])
    lines = np.tile([-1.0, 0.0, -0.4 * directions[1, 0]], (3, 1))
    edges = np.tile([100.0, 120.0], (3, 1))
    late = np.full((3, 200), -1e-4 * 80.0)
    sight = np.tile([0.1, 0.9], (3, 1))
    unskew(ranges, sight, lines, edges, late, directions, 0.0, 0.0, 0.2)
    assert np.isfinite(ranges).tolist() == [False, True, False]
