"""Rays end exactly where they enter tape."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from robot.fields.edges import normals, outline
from robot.fields.field_loading import load_field
from robot.geometry import Array, heading_vectors
from robot.localization.models.ray_casting import cast_ray, cast_rays

STUB = load_field("stub", Path(__file__).parent.parent / "maps")
WALL = np.array([[1.0, 1.0, 1.0, -1.0]])
"""Dark on its left, which is beyond x = 1."""


def brute_force(x: float, y: float, heading: float, edges: Array, reach: float) -> float:
    """By shapely: the nearest crossing of an edge from its light side."""
    toward = heading_vectors(np.array([heading]))[0]
    ray = shapely.linestrings([(x, y), (x + reach * toward[0], y + reach * toward[1])])
    facing = normals(edges) @ toward < 0
    met = shapely.intersection(shapely.linestrings(edges[facing].reshape(-1, 2, 2)), ray)
    distances = shapely.distance(shapely.points(x, y), met)
    return float(np.nanmin(np.append(distances, np.inf)))


def test_random_rays_end_where_geometry_says() -> None:
    rng = np.random.default_rng(0)
    poses = STUB.free_poses(rng, 150)
    bearings = np.linspace(-math.pi, math.pi, 24)
    found = np.empty((150, 24))
    cast_rays(poses, bearings, STUB.edges, 0.9, found)
    expected = [
        [brute_force(x, y, theta + b, STUB.edges, 0.9) for b in bearings] for x, y, theta in poses
    ]
    np.testing.assert_allclose(found, expected, atol=1e-9)
    assert 0.5 < np.isfinite(found).mean() < 1, "some rays reach nothing"


def test_one_ray_is_a_scan_of_one() -> None:
    found = np.empty((1, 1))
    cast_rays(np.array([[0.1, 0.2, 0.3]]), np.array([0.4]), STUB.edges, 2.0, found)
    assert found[0, 0] == cast_ray(0.1, 0.2, 0.3 + 0.4, STUB.edges, 2.0)


def test_an_edge_is_met_from_its_light_side_only() -> None:
    assert cast_ray(0.0, 0.0, 0.0, WALL, 5.0) == 1.0
    assert cast_ray(2.0, 0.0, math.pi, WALL, 5.0) == math.inf, "out of the dark"
    assert cast_ray(0.0, 0.0, math.pi, WALL, 5.0) == math.inf, "looking away"
    assert cast_ray(2.0, 0.0, math.pi, WALL[:, [2, 3, 0, 1]], 5.0) == 1.0, "the other way round"


def test_from_on_the_tape_the_next_tape_is_met() -> None:
    tape = outline(shapely.union_all([shapely.box(-0.1, -1, 0.1, 1), shapely.box(1, -1, 1.2, 1)]))
    assert cast_ray(0.0, 0.0, 0.0, tape, 5.0) == pytest.approx(1.0)


def test_the_nearest_of_several_edges_counts_in_any_order() -> None:
    walls = np.array([[x, 1, x, -1] for x in (3.0, 1.0, 2.0)])
    for order in ([0, 1, 2], [2, 1, 0], [1, 0, 2]):
        assert cast_ray(0.0, 0.0, 0.0, walls[order], 5.0) == 1.0


@pytest.mark.parametrize(("reach", "found"), [(0.999, math.inf), (1.0, 1.0), (1.001, 1.0)])
def test_beyond_its_reach_a_ray_meets_nothing(reach: float, found: float) -> None:
    assert cast_ray(0.0, 0.0, 0.0, WALL, reach) == found


def test_past_the_end_of_an_edge_there_is_none() -> None:
    end = math.atan2(1, 1)
    assert cast_ray(0.0, 0.0, end - 1e-9, WALL, 5.0) == pytest.approx(math.sqrt(2))
    assert cast_ray(0.0, 0.0, end + 1e-9, WALL, 5.0) == math.inf


def test_no_ray_slips_through_where_two_edges_meet() -> None:
    corner = outline(shapely.box(1, -1, 2, 1))
    for y in (0.0, 1.0 - 1e-12, -1.0 + 1e-12):
        assert cast_ray(0.0, y, 0.0, corner, 5.0) == pytest.approx(1.0)
    parts = np.array([[1.0, y + 0.1, 1.0, y] for y in np.arange(-10, 10) / 10])
    for y in np.arange(-9, 10) / 10:
        assert cast_ray(0.0, float(y), 0.0, parts, 5.0) == pytest.approx(1.0)


def test_an_edge_along_the_ray_is_not_met() -> None:
    assert cast_ray(1.0, -2.0, math.pi / 2, WALL, 5.0) == pytest.approx(math.inf)
    assert cast_ray(0.0, 0.0, 0.0, np.array([[1.0, 0, 2, 0]]), 5.0) == math.inf


def test_from_on_the_edge_itself_the_distance_is_zero() -> None:
    assert cast_ray(1.0, 0.0, 0.0, WALL, 5.0) == 0.0


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
    found = cast_ray(*start, edge, 3.0)
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
