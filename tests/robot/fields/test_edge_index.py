"""An index of edges names, for each cell, every edge that touches it and hardly any other."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from places import MAPS

from robot.fields.edge_index import FEW, EdgeIndex, index_edges
from robot.fields.field_loading import load_field
from robot.geometry import Array

TOWN = load_field("town", MAPS)
PLACES = st.one_of(st.integers(-10, 10).map(lambda tenths: tenths / 10), st.floats(-1, 1))
EDGES = st.lists(st.tuples(PLACES, PLACES, PLACES, PLACES), min_size=1, max_size=40).map(np.array)


def cells(index: EdgeIndex) -> list[set[int]]:
    """The edges of each cell."""
    return [set(part) for part in np.split(index.items, index.starts[1:-1])]


def touched(index: EdgeIndex, grow: float) -> list[set[int]]:
    """The same by shapely, with cells grown on all sides [m]."""
    row, column = np.divmod(np.arange(index.rows * index.columns), index.columns)
    left, bottom = index.x + column * index.cell, index.y + row * index.cell
    squares = shapely.box(
        left - grow, bottom - grow, left + index.cell + grow, bottom + index.cell + grow
    )
    tree = shapely.STRtree(shapely.linestrings(index.edges.reshape(-1, 2, 2)))
    found: list[set[int]] = [set() for _ in squares]
    for cell, edge in tree.query(squares, predicate="intersects").T:
        found[cell].add(int(edge))
    return found


@given(EDGES, st.sampled_from([0.1, 0.2, 0.27, 1.0]))
def test_a_cell_has_the_edges_that_touch_it_and_no_others(edges: Array, cell: float) -> None:
    index = index_edges(edges, cell)
    some = zip(touched(index, 0), cells(index), touched(index, 1e-4 * cell), strict=True)
    for inside, named, near in some:
        assert inside <= named <= near


def test_the_town_is_sorted_into_small_cells() -> None:
    index = TOWN.edge_index
    assert index is TOWN.edge_index
    for inside, named in zip(touched(index, 0), cells(index), strict=True):
        assert inside <= named
    assert len(index.items) < 2 * len(TOWN.edges)
    assert max(map(len, cells(index))) < 0.05 * len(TOWN.edges)


def test_few_edges_are_one_cell() -> None:
    for count in (0, 1, FEW):
        edges = np.random.default_rng(0).uniform(-1, 1, (count, 4))
        assert cells(index_edges(edges)) == [set(range(count))]


@pytest.mark.parametrize("shape", ["a line", "a point", "upright", "a far place", "a cluster"])
def test_any_lie_of_the_edges_is_sorted_into_not_too_many_cells(shape: str) -> None:
    rng = np.random.default_rng(0)
    edges = {
        "a line": np.column_stack(
            [np.arange(500), np.zeros(500), np.arange(1, 501), np.zeros(500)]
        ),
        "a point": np.tile([0.3, 0.2, 0.3, 0.2], (500, 1)),
        "upright": np.column_stack(
            [np.zeros(500), np.arange(500), np.zeros(500), np.arange(1, 501)]
        ),
        "a far place": 1e5 + rng.uniform(0, 1, (500, 4)),
        "a cluster": np.vstack([rng.uniform(0, 0.01, (499, 4)), [[90, 90, 91, 91]]]),
    }[shape].astype(float)
    index = index_edges(edges)
    assert index.rows * index.columns <= 2 * 500
    assert set(index.items) == set(range(500))


def test_the_edges_are_kept_as_they_are() -> None:
    edges = TOWN.edges.copy()
    index = index_edges(edges)
    np.testing.assert_array_equal(index.edges, edges)
    edges[:] = 0
    assert np.ptp(index.edges) > 0, "a copy"
    with pytest.raises(ValueError, match="read-only"):
        index.edges[0, 0] = 1.0


def test_what_is_no_edge_or_no_cell_is_refused() -> None:
    with pytest.raises(ValueError, match=r"shape \(4,\); valid is \(n, 4\)"):
        index_edges(np.zeros(4))
    for cell in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(ValueError, match=r"the cell is .* m; valid is more than 0"):
            index_edges(TOWN.edges, cell)
