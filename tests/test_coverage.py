import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from robot.fields.drawing.coverage import coverage
from robot.fields.edges import outline


def by_clipping(area, shape):
    """The covered share of each cell, by cutting the area with the cell."""
    rows, columns = np.mgrid[: shape[0], : shape[1]]
    cells = shapely.box(columns, rows, columns + 1, rows + 1)
    return shapely.area(shapely.intersection(cells, area))


def test_a_box_between_grid_lines_covers_parts_of_cells():
    covered = coverage(outline(shapely.box(0.5, 0.25, 2.5, 1.25)), (3, 4))
    expected = np.outer([0.75, 0.25, 0], [0.5, 1, 0.5, 0])
    assert np.allclose(covered, expected, atol=1e-12)


def test_a_box_on_grid_lines_covers_whole_cells():
    covered = coverage(outline(shapely.box(1, 0, 3, 2)), (3, 4))
    assert covered.tolist() == [[0, 1, 1, 0], [0, 1, 1, 0], [0, 0, 0, 0]]


def test_what_lies_outside_the_grid_is_cut_off():
    covered = coverage(outline(shapely.box(-5, -5, 9, 1.5)), (3, 4))
    assert np.allclose(covered, np.outer([1, 0.5, 0], np.ones(4)), atol=1e-12)


def test_nothing_covers_nothing():
    assert not coverage(np.empty((0, 4)), (2, 3)).any()


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(3, 9))
def test_coverage_is_the_area_of_each_cell_that_lies_inside(seed, corners):
    rng = np.random.default_rng(seed)
    disc = shapely.MultiPoint(rng.uniform(-2, 9, (corners, 2))).convex_hull
    hole = shapely.MultiPoint(rng.uniform(0, 7, (4, 2))).convex_hull
    area = shapely.difference(disc, hole)
    shape = (6, 8)
    assert np.allclose(coverage(outline(area), shape), by_clipping(area, shape), atol=1e-9)


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.7853981633974483, 1.5])
def test_the_sum_is_the_area(angle):
    box = shapely.box(-4.3, -2.1, 4.3, 2.1)
    c, s = np.cos(angle), np.sin(angle)
    turned = shapely.transform(box, lambda points: points @ [[c, s], [-s, c]] + 10)
    assert coverage(outline(turned), (20, 20)).sum() == pytest.approx(8.6 * 4.2, abs=1e-9)
