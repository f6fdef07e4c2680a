import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from robot.fields.edges import lengths, normals, outline, sample

EAST = np.array([[0.0, 0.0, 2.0, 0.0]])
UNIT = shapely.box(0, 0, 1, 1)


def area_to_the_left(edges):
    """By the shoelace formula."""
    return (edges[:, 0] * edges[:, 3] - edges[:, 2] * edges[:, 1]).sum() / 2


def test_the_normal_points_away_from_the_dark_left_side():
    assert normals(EAST).tolist() == [[0.0, -1.0]]
    assert lengths(EAST).tolist() == [2.0]


def test_samples_are_the_middles_of_equal_parts_no_longer_than_the_step():
    points, across = sample(EAST, 0.9)
    assert np.allclose(points, [[1 / 3, 0], [1, 0], [5 / 3, 0]])
    assert across.tolist() == [[0.0, -1.0]] * 3


def test_an_edge_of_whole_steps_is_not_cut_once_more_by_rounding():
    edge = np.array([[0.1, 0.0, 0.4, 0.0]])
    assert len(sample(edge, 0.1)[0]) == 3


def test_a_short_edge_still_has_one_sample():
    points, _ = sample(np.array([[0.0, 0.0, 0.001, 0.0]]), 1.0)
    assert np.allclose(points, [[0.0005, 0]])


@pytest.mark.parametrize("step", [0.0, -1.0, float("nan"), float("inf")])
def test_a_step_that_is_no_length_is_refused(step):
    with pytest.raises(ValueError, match="valid is more than 0"):
        sample(EAST, step)


@settings(deadline=None)
@given(st.floats(0.01, 10), st.integers(0, 2**32 - 1))
def test_samples_lie_on_their_edges_and_are_close_to_each_other(step, seed):
    edges = np.random.default_rng(seed).uniform(-5, 5, (7, 4))
    points, across = sample(edges, step)
    lines = shapely.multilinestrings(edges.reshape(-1, 2, 2))
    assert shapely.distance(lines, shapely.points(points)).max() < 1e-9
    assert len(points) >= (lengths(edges) / step).sum()
    assert np.allclose(np.hypot(*across.T), 1)


@pytest.mark.parametrize("area", [UNIT, shapely.reverse(UNIT)])
def test_an_outline_has_the_area_to_its_left_whatever_the_ring_says(area):
    edges = outline(area)
    assert len(edges) == 4
    assert area_to_the_left(edges) == pytest.approx(1)
    centre = np.array([0.5, 0.5])
    assert (((edges[:, :2] - centre) * normals(edges)).sum(axis=1) > 0).all()


def test_a_hole_is_light_inside():
    ring = shapely.box(0, 0, 3, 3) - shapely.box(1, 1, 2, 2)
    edges = outline(ring)
    inner = edges[np.abs(edges - 1.5).max(axis=1) < 1]
    assert len(edges) == 8
    assert len(inner) == 4
    middle = (inner[:, :2] + inner[:, 2:]) / 2
    assert np.allclose(middle + normals(inner) / 2, 1.5)


def test_several_polygons_do_not_share_edges():
    edges = outline(shapely.union_all([UNIT, shapely.box(5, 5, 6, 6)]))
    assert len(edges) == 8
    assert lengths(edges).tolist() == [1.0] * 8


def test_nothing_has_no_outline():
    assert outline(shapely.Polygon()).shape == (0, 4)
