"""Rays end exactly where they enter tape, however many edges lie elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from floor_looks import cast_ray
from hypothesis import given
from hypothesis import strategies as st
from places import MAPS

from robot.fields.edge_index import EdgeIndex, index_edges
from robot.fields.edges import normals, outline
from robot.fields.field_loading import load_field
from robot.fields.ray_casting import cast_rays
from robot.geometry import Array, heading_vectors

STUB, TOWN = load_field("stub", MAPS), load_field("town", MAPS)
WALL = np.array([[1.0, 1.0, 1.0, -1.0]])
"""Dark on its left, which is beyond x = 1."""


def cast(x: float, y: float, heading: float, edges: Array, reach: float) -> float:
    """The distance alone."""
    return cast_ray(x, y, heading, index_edges(edges), reach)[0]


def brute_force(x: float, y: float, heading: float, edges: Array, reach: float) -> float:
    """By shapely: the nearest crossing of an edge from its light side."""
    toward = heading_vectors(np.array([heading]))[0]
    ray = shapely.linestrings([(x, y), (x + reach * toward[0], y + reach * toward[1])])
    facing = normals(edges) @ toward < 0
    met = shapely.intersection(shapely.linestrings(edges[facing].reshape(-1, 2, 2)), ray)
    distances = shapely.distance(shapely.points(x, y), met)
    return float(np.nanmin(np.append(distances, np.inf)))


# --- where a ray ends


@pytest.mark.slow
@pytest.mark.parametrize("field", [STUB, TOWN], ids=["stub", "town"])
def test_random_rays_end_where_geometry_says(field: object) -> None:
    assert isinstance(field, type(STUB))
    rng = np.random.default_rng(0)
    poses = field.free_poses(rng, 60)
    bearings = np.linspace(-math.pi, math.pi, 24)
    found = np.empty((60, 24))
    cast_rays(poses, bearings, field.edge_index, 0.7, found)
    expected = [
        [brute_force(x, y, theta + b, field.edges, 0.7) for b in bearings] for x, y, theta in poses
    ]
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert 0.3 < np.isfinite(found).mean() < 1, "some rays reach nothing"


def test_one_ray_is_a_scan_of_one() -> None:
    found = np.empty((1, 1))
    cast_rays(np.array([[0.1, 0.2, 0.3]]), np.array([0.4]), STUB.edge_index, 2.0, found)
    assert found[0, 0] == cast_ray(0.1, 0.2, 0.3 + 0.4, STUB.edge_index, 2.0)[0]


def test_an_edge_is_met_from_its_light_side_only() -> None:
    assert cast(0.0, 0.0, 0.0, WALL, 5.0) == 1.0
    assert cast(2.0, 0.0, math.pi, WALL, 5.0) == math.inf, "out of the dark"
    assert cast(0.0, 0.0, math.pi, WALL, 5.0) == math.inf, "looking away"
    assert cast(2.0, 0.0, math.pi, WALL[:, [2, 3, 0, 1]], 5.0) == 1.0, "the other way round"


def test_from_on_the_tape_the_next_tape_is_met() -> None:
    tape = outline(shapely.union_all([shapely.box(-0.1, -1, 0.1, 1), shapely.box(1, -1, 1.2, 1)]))
    assert cast(0.0, 0.0, 0.0, tape, 5.0) == pytest.approx(1.0)


def test_the_nearest_of_several_edges_counts_in_any_order() -> None:
    walls = np.array([[x, 1, x, -1] for x in (3.0, 1.0, 2.0)])
    for order in ([0, 1, 2], [2, 1, 0], [1, 0, 2]):
        found = cast_ray(0.0, 0.0, 0.0, index_edges(walls[order]), 5.0)
        assert found == (1.0, order.index(1))


def test_a_ray_that_meets_nothing_names_no_edge() -> None:
    assert cast_ray(0.0, 0.0, math.pi, index_edges(WALL), 5.0) == (math.inf, -1)
    assert cast_ray(0.0, 0.0, 0.0, index_edges(np.empty((0, 4))), 5.0) == (math.inf, -1)


@pytest.mark.parametrize(("reach", "found"), [(0.999, math.inf), (1.0, 1.0), (1.001, 1.0)])
def test_beyond_its_reach_a_ray_meets_nothing(reach: float, found: float) -> None:
    assert cast(0.0, 0.0, 0.0, WALL, reach) == found
    assert cast_ray(0.0, 0.0, 0.0, index_edges(WALL, 0.3), reach)[0] == found


def test_past_the_end_of_an_edge_there_is_none() -> None:
    end = math.atan2(1, 1)
    assert cast(0.0, 0.0, end - 1e-9, WALL, 5.0) == pytest.approx(math.sqrt(2))
    assert cast(0.0, 0.0, end + 1e-9, WALL, 5.0) == math.inf


def test_no_ray_slips_through_where_two_edges_meet() -> None:
    corner = outline(shapely.box(1, -1, 2, 1))
    for y in (0.0, 1.0 - 1e-12, -1.0 + 1e-12):
        assert cast(0.0, y, 0.0, corner, 5.0) == pytest.approx(1.0)
    parts = np.array([[1.0, y + 0.1, 1.0, y] for y in np.arange(-10, 10) / 10])
    for y in np.arange(-9, 10) / 10:
        assert cast(0.0, float(y), 0.0, parts, 5.0) == pytest.approx(1.0)


@given(st.floats(-math.pi, math.pi), st.integers(3, 400))
def test_no_ray_gets_out_of_a_ring_through_one_of_its_corners(turn: float, sides: int) -> None:
    """Aimed at each corner; the ring is dark outside."""
    angles = turn + np.arange(sides + 1) * (-2 * math.pi / sides)
    corners = 0.7 * heading_vectors(np.asarray(angles))
    corners[-1] = corners[0]
    ring = index_edges(np.hstack([corners[:-1], corners[1:]]))
    found = np.empty((1, sides))
    cast_rays(np.zeros((1, 3)), np.arctan2(*corners[:-1, ::-1].T), ring, 5.0, found)
    np.testing.assert_allclose(found, 0.7, rtol=1e-9)


def test_an_edge_along_the_ray_is_not_met() -> None:
    assert cast(1.0, -2.0, math.pi / 2, WALL, 5.0) == pytest.approx(math.inf)
    assert cast(0.0, 0.0, 0.0, np.array([[1.0, 0, 2, 0]]), 5.0) == math.inf


def test_from_on_the_edge_itself_the_distance_is_zero() -> None:
    assert cast(1.0, 0.0, 0.0, WALL, 5.0) == 0.0


@given(
    st.tuples(*[st.floats(-2, 2)] * 3),
    st.tuples(*[st.floats(-2, 2)] * 4).filter(
        lambda e: math.hypot(e[2] - e[0], e[3] - e[1]) > 0.05
    ),
)
def test_any_ray_and_any_edge_meet_as_geometry_says(
    start: tuple[float, float, float], ends: tuple[float, float, float, float]
) -> None:
    edge = np.array([ends])
    found = cast(*start, edge, 3.0)
    expected = brute_force(*start, edge, 3.0)
    if math.isfinite(found) and math.isfinite(expected):
        assert found == pytest.approx(expected, abs=1e-6)
    elif math.isfinite(found) or math.isfinite(expected):
        # By a hair: at an end of the edge, of the ray, or along the edge.
        toward = heading_vectors(np.array([start[2]]))[0]
        reach = shapely.linestrings([start[:2], np.add(start[:2], 3.0 * toward)])
        to_ends = shapely.distance(reach, shapely.points(edge.reshape(2, 2))).min()
        to_rims = shapely.distance(
            shapely.linestrings(edge.reshape(2, 2)), shapely.points(shapely.get_coordinates(reach))
        ).min()
        assert min(to_ends, to_rims, abs(float(normals(edge)[0] @ toward))) < 1e-6


# --- the index leaves nothing out

HEADINGS = st.one_of(
    st.integers(-4, 4).map(lambda quarter: quarter * math.pi / 4), st.floats(-math.pi, math.pi)
)
# Whole tenths lie on the borders of cells of a tenth, a fifth and a half.
PLACES = st.one_of(st.integers(-10, 10).map(lambda tenths: tenths / 10), st.floats(-1, 1))
EDGES = st.lists(st.tuples(PLACES, PLACES, PLACES, PLACES), min_size=1, max_size=40).map(np.array)
FAR = st.one_of(PLACES, st.floats(-1e4, 1e4))


def whole(edges: Array) -> EdgeIndex:
    """One cell for all: the exhaustive search."""
    found = index_edges(edges, 100.0)
    assert found.columns * found.rows == 1
    return found


def look(start: tuple[float, float, float], edges: Array, cell: float | None, reach: float) -> None:
    assert cast_ray(*start, index_edges(edges, cell), reach) == cast_ray(
        *start, whole(edges), reach
    )


@given(
    EDGES,
    st.tuples(FAR, FAR, HEADINGS),
    st.sampled_from([None, 0.1, 0.2, 0.5, 0.037]),
    st.sampled_from([0.3, 1.0, 3.0, 1e5, math.inf]),
)
def test_the_index_finds_what_the_exhaustive_search_finds(
    edges: Array, start: tuple[float, float, float], cell: float | None, reach: float
) -> None:
    """To the last bit, from within, from outside, and along the borders of cells."""
    look(start, edges, cell, reach)


@given(EDGES, st.integers(0, 39), st.floats(0, 1), HEADINGS, st.sampled_from([None, 0.1, 0.2]))
def test_so_it_does_from_on_an_edge_and_toward_one(
    edges: Array, which: int, part: float, heading: float, cell: float | None
) -> None:
    x0, y0, x1, y1 = edges[which % len(edges)]
    x, y = x0 + part * (x1 - x0), y0 + part * (y1 - y0)
    look((x, y, heading), edges, cell, 3.0)
    look((x - 2 * math.cos(heading), y - 2 * math.sin(heading), heading), edges, cell, 3.0)
    look((x, y, math.atan2(y1 - y0, x1 - x0)), edges, cell, 3.0)


@given(st.integers(-15, 15), st.sampled_from([0.1, 0.25]), st.integers(0, 3), EDGES)
def test_so_it_does_along_the_very_borders_of_its_cells(
    line: int, cell: float, quarter: int, edges: Array
) -> None:
    index = index_edges(edges, cell)
    x, y = index.x + line * cell, index.y + line * cell
    for start in ((x, -1.3), (-1.3, y), (x, y), (x, 0.1)):
        look((*start, quarter * math.pi / 2), edges, cell, 5.0)


def test_on_the_town_it_finds_what_the_exhaustive_search_finds() -> None:
    poses = np.random.default_rng(3).uniform([-1, -1, -math.pi], [3, 3, math.pi], (300, 3))
    bearings = np.linspace(-0.6, 0.6, 20)
    indexed, exhaustive = np.empty((2, 300, 20))
    cast_rays(poses, bearings, TOWN.edge_index, 1.5, indexed)
    cast_rays(poses, bearings, whole(TOWN.edges), 1.5, exhaustive)
    np.testing.assert_array_equal(indexed, exhaustive)
    assert 0.2 < np.isfinite(indexed).mean() < 1


@pytest.mark.parametrize("odd", [math.nan, math.inf, -math.inf, 1e300, -1e300])
def test_a_start_that_is_nowhere_meets_nothing(odd: float) -> None:
    for edges in (TOWN.edge_index, STUB.edge_index):
        for start in ((odd, 0.0, 0.3), (0.0, odd, 0.3), (odd, odd, 0.3), (odd, odd, math.pi)):
            for reach in (1.0, math.inf):
                assert cast_ray(*start, edges, reach) == (math.inf, -1)
    assert cast_ray(0.0, 0.0, math.nan, TOWN.edge_index, 1.0) == (math.inf, -1)
