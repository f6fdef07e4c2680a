"""The grid of poses covers a field, and its costs are what the sum over ray ends says."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from stub_drive import ENTRIES, MAPS, Drive

from robot import ray_columns as column
from robot.fields.field_loading import load_field
from robot.geometry import Array, Pose2, wrap_angle
from robot.localization.hypotheses import coarse_grid
from robot.localization.hypotheses.coarse_grid import Cheapest, CoarseGrid
from robot.localization.models.entry_field import DIRECTIONS, EntryField
from robot.scan import rays_of

BLUR = 0.03


def ends_at(true: Pose2) -> Array:
    rays = rays_of(Drive(true).scan(), 12)
    rays = rays[np.isfinite(rays[:, column.RANGE])]
    ranges, directions = rays[:, column.RANGE], rays[:, column.DIRECTION]
    return np.column_stack([ranges * np.cos(directions), ranges * np.sin(directions), directions])


def slow_cost(pose: Pose2, ends: Array, entries: EntryField = ENTRIES) -> float:
    """One pose, by the definition: the nearest cell of the nearest direction."""
    total = 0.0
    for x, y, direction in ends:
        end = pose @ Pose2(x, y, direction)
        turn = round((pose.theta + direction) * DIRECTIONS / (2 * math.pi)) % DIRECTIONS
        column = round((end.x - entries.origin[0]) / entries.resolution)
        row = round((end.y - entries.origin[1]) / entries.resolution)
        height, width = entries.distances.shape[1:]
        if not (0 <= row < height and 0 <= column < width):
            total += 1
            continue
        d = float(entries.distances[turn, row, column])
        total += d**2 / (d**2 + BLUR**2)
    return total


def grid_over(entries: EntryField, step_xy: float, step_theta: float) -> CoarseGrid:
    """Over the box of the edges that a table is of."""
    rows, columns = entries.distances.shape[1:]
    low = np.add(entries.origin, entries.max_distance)
    size = np.subtract((columns, rows), 1) * entries.resolution - 2 * entries.max_distance
    (xmin, ymin), (xmax, ymax) = low.tolist(), (low + size).tolist()
    return CoarseGrid.over((xmin, ymin, xmax, ymax), step_xy, step_theta)


def costs_of(grid: CoarseGrid, ends: Array) -> Array:
    costs = np.full(grid.shape, np.nan, dtype=np.float32)
    grid.score(slice(0, grid.shape[0]), ends, ENTRIES, BLUR, costs)
    return costs.astype(np.float64)


# --- which poses


def test_it_covers_the_edges_in_steps_no_larger_than_asked_for() -> None:
    grid = grid_over(ENTRIES, 0.04, math.radians(6))
    assert grid.shape == (60, len(grid.ys), len(grid.xs))
    for axis in (grid.xs, grid.ys):
        assert np.diff(axis).max() <= 0.04 + 0.005
        # No point of the edges' box is farther than half a step from the grid.
        assert axis[0] <= -0.525 + 0.025 and axis[-1] >= 0.525 - 0.025
        assert axis[0] >= -0.53 and axis[-1] <= 0.53
    np.testing.assert_allclose(np.diff(grid.thetas), math.radians(6))
    assert grid.thetas[0] == -math.pi
    assert grid.thetas[-1] == pytest.approx(math.pi - math.radians(6))


def test_poses_are_those_of_their_cells() -> None:
    grid = grid_over(ENTRIES, 0.1, 0.5)
    cells = np.array([[0, 0, 0], [3, 1, 2], [grid.shape[0] - 1, 5, 7]])
    wanted = [[grid.xs[x], grid.ys[y], grid.thetas[t]] for t, y, x in cells]
    np.testing.assert_array_equal(grid.poses(cells), wanted)


def test_a_large_field_gets_a_coarser_grid(monkeypatch: pytest.MonkeyPatch) -> None:
    fine = grid_over(ENTRIES, 0.01, 0.1)
    monkeypatch.setattr(coarse_grid, "MOST_POSES", 20_000)
    coarse = grid_over(ENTRIES, 0.01, 0.1)
    assert math.prod(fine.shape) > 400_000
    assert 10_000 < math.prod(coarse.shape) < 25_000
    assert coarse.shape[0] == fine.shape[0] == 63
    assert np.ptp(coarse.xs) > 0.9


def test_a_field_of_a_hundred_metres_is_no_burden() -> None:
    large = EntryField(np.zeros((8, 601, 801), dtype=np.float32), (-60, -50), 0.15, 0.15, 0.005)
    grid = grid_over(large, 0.04, math.radians(6))
    assert math.prod(grid.shape) < 1.1 * coarse_grid.MOST_POSES
    assert grid.xs[0] < -58 and grid.xs[-1] > 58


def test_a_field_without_width_has_poses_all_the_same() -> None:
    line = EntryField(np.zeros((8, 61, 1), dtype=np.float32), (-0.15, -0.15), 0.005, 0.0, 0.005)
    grid = grid_over(line, 0.04, 1.0)
    costs = np.empty(grid.shape, dtype=np.float32)
    grid.score(slice(0, grid.shape[0]), np.zeros((1, 3)), line, BLUR, costs)
    assert grid.shape[2] == 1 and (costs == 0).all()


# --- what they cost


@pytest.mark.parametrize("true", [Pose2(0.1, -0.05, 0.4), Pose2(-0.3, 0.2, -3.0)], ids=str)
def test_costs_are_the_sum_over_the_ends(true: Pose2) -> None:
    grid, ends = grid_over(ENTRIES, 0.0913, 0.7), ends_at(true)
    costs = costs_of(grid, ends)
    cells = np.argwhere(np.isfinite(costs))
    slow = [slow_cost(Pose2.from_array(pose), ends) for pose in grid.poses(cells)]
    # An end halfway between two cells may be rounded to either.
    off = np.abs(costs.ravel() - slow)
    assert np.quantile(off, 0.99) < 1e-4
    assert off.max() < 0.5
    assert 0 < costs.min() < costs.max() <= len(ends)


def test_some_headings_are_scored_and_the_others_left() -> None:
    grid, ends = grid_over(ENTRIES, 0.1, 0.5), ends_at(Pose2())
    costs = np.full(grid.shape, -1, dtype=np.float32)
    grid.score(slice(3, 5), ends, ENTRIES, BLUR, costs)
    np.testing.assert_array_equal(costs[3:5], costs_of(grid, ends)[3:5].astype(np.float32))
    assert (costs[:3] == -1).all() and (costs[5:] == -1).all()


def test_an_end_off_the_table_costs_as_much_as_one_can() -> None:
    grid = grid_over(ENTRIES, 0.1, 0.5)
    far = np.array([[9.0, 0.0, 0.0], [0.0, -9.0, 1.0]])
    np.testing.assert_array_equal(costs_of(grid, far), 2)


@pytest.mark.parametrize("seed", range(4))
def test_the_truth_is_among_the_cheapest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    true = Pose2.from_array(rng.uniform([-0.2, -0.2, -3], [0.2, 0.2, 3]))
    grid = grid_over(ENTRIES, 0.04, math.radians(6))
    costs = np.empty(grid.shape, dtype=np.float32)
    grid.score(slice(0, 60), ends_at(true), ENTRIES, BLUR, costs)
    nearest = (
        int(np.argmin(np.abs(wrap_angle(grid.thetas - true.theta)))),
        int(np.argmin(np.abs(grid.ys - true.y))),
        int(np.argmin(np.abs(grid.xs - true.x))),
    )
    assert costs[nearest] < np.quantile(costs, 0.02)


def test_the_largest_drawing_here_is_covered() -> None:
    town = load_field("town", MAPS)
    entries = EntryField.build(town, resolution=0.02, max_distance=0.15)
    grid = grid_over(entries, 0.2, 0.5)
    low, high = town.edges.reshape(-1, 2).min(axis=0), town.edges.reshape(-1, 2).max(axis=0)
    assert abs(grid.xs[0] - low[0]) < 0.12 and abs(grid.xs[-1] - high[0]) < 0.14
    assert abs(grid.ys[0] - low[1]) < 0.12 and abs(grid.ys[-1] - high[1]) < 0.14


# --- which are the cheapest


def cheapest(costs: NDArray[np.float32], most: int) -> NDArray[np.int64]:
    """Looked for in pieces of two headings, as a search does."""
    found = Cheapest(most, 1e9)
    for first in range(0, len(costs), 2):
        found.look(costs, slice(first, first + 2))
    return found.cells


def test_what_costs_more_than_the_limit_is_no_place() -> None:
    costs = np.full((4, 3, 3), 5, dtype=np.float32)
    costs[1, 1, 1] = 2
    found = Cheapest(10, 4.5)
    found.look(costs, slice(0, 4))
    assert found.cells.tolist() == [[1, 1, 1]]


def lowest_by_force(costs: NDArray[np.float32]) -> list[tuple[float, int, int, int]]:
    turns, height, width = costs.shape
    found = []
    for t, y, x in np.ndindex(*costs.shape):
        around = [
            costs[(t + dt) % turns, v, u]
            for dt in (-1, 0, 1)
            for v in range(max(y - 1, 0), min(y + 2, height))
            for u in range(max(x - 1, 0), min(x + 2, width))
        ]
        if min(around) >= costs[t, y, x]:
            found.append((float(costs[t, y, x]), t, y, x))
    return sorted(found)


@settings(max_examples=60)
@given(
    arrays(
        np.float32,
        st.tuples(st.integers(1, 6), st.integers(1, 6), st.integers(1, 6)),
        elements=st.integers(0, 9).map(float),
    ),
    st.integers(0, 12),
)
def test_the_cheapest_are_those_no_neighbour_undercuts(
    costs: NDArray[np.float32], most: int
) -> None:
    wanted = [cell[1:] for cell in lowest_by_force(costs)[:most]]
    assert [tuple(cell) for cell in cheapest(costs, most).tolist()] == wanted


def test_the_first_heading_and_the_last_are_neighbours() -> None:
    costs = np.full((8, 3, 3), 5, dtype=np.float32)
    costs[0, 1, 1], costs[7, 1, 1], costs[4, 1, 1] = 1, 2, 3
    found = cheapest(costs, 2).tolist()
    assert found == [[0, 1, 1], [4, 1, 1]]


def test_both_neighbours_on_the_rim_are_no_neighbours_across_the_field() -> None:
    costs = np.full((1, 1, 8), 5, dtype=np.float32)
    costs[0, 0, 0], costs[0, 0, 7] = 1, 2
    assert cheapest(costs, 2).tolist() == [[0, 0, 0], [0, 0, 7]]


def test_it_does_not_depend_on_the_fields_own_place() -> None:
    """A table moved by a metre, with all poses moved as well."""
    moved = replace(ENTRIES, origin=(ENTRIES.origin[0] + 1, ENTRIES.origin[1] - 2))
    here = grid_over(ENTRIES, 0.1, 0.5)
    there = grid_over(moved, 0.1, 0.5)
    np.testing.assert_allclose(there.xs - here.xs, 1)
    np.testing.assert_allclose(there.ys - here.ys, -2)
    ends = ends_at(Pose2(0.1, 0.1, 0.3))
    costs = np.empty(there.shape, dtype=np.float32)
    there.score(slice(0, there.shape[0]), ends, moved, BLUR, costs)
    assert np.quantile(np.abs(costs - costs_of(here, ends)), 0.99) < 1e-4
