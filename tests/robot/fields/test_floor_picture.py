import math

import numpy as np
import pytest
import shapely
from floor_looks import grey_at
from hypothesis import given, settings
from hypothesis import strategies as st

from robot.fields.edges import outline
from robot.fields.floor_picture import (
    MAX_PIXELS,
    FloorPicture,
    Layer,
    coverage,
    finest_resolution,
    paint,
)

EXTENT = (-0.2, -0.1, 0.2, 0.1)
LIGHT, DARK = 200.0, 40.0
FLOOR = Layer(shapely.box(*EXTENT), LIGHT)


def dark_share(picture):
    return (LIGHT - picture.image.astype(float)) / (LIGHT - DARK)


def test_pixels_are_a_millimetre_and_row_0_is_at_the_top():
    picture = paint(EXTENT, [FLOOR, Layer(shapely.box(-0.2, 0.0, 0.2, 0.1), DARK)])
    assert picture.image.shape == (200, 400)
    assert picture.resolution == 0.001
    assert (picture.image[:100] == DARK).all()
    assert (picture.image[100:] == LIGHT).all()


def test_pixel_centres_have_whole_coordinates():
    picture = paint(EXTENT, [FLOOR])
    affine = picture.pixel_from_map
    centre_of_first = np.array([-0.2 + 0.0005, 0.1 - 0.0005, 1.0])
    assert np.allclose(affine @ centre_of_first, [0, 0])
    assert np.allclose(affine @ [0.2, -0.1, 1.0], [399.5, 199.5])


def test_a_large_floor_gets_coarser_pixels_but_not_more_of_them():
    assert finest_resolution(4.0, 4.0) == 0.001
    assert finest_resolution(100.0, 100.0) == pytest.approx(0.025)
    picture = paint((0.0, 0.0, 7.3, 9.1), [])
    assert 0.98 * MAX_PIXELS < picture.image.size <= MAX_PIXELS
    xmin, ymin, xmax, ymax = picture.extent
    assert (xmin, ymax) == (0.0, 9.1)
    assert 7.3 - picture.resolution < xmax <= 7.3
    assert 0 <= ymin < picture.resolution


@pytest.mark.parametrize("angle", [0.0, 0.02, 0.3, math.pi / 4])
def test_the_dark_area_is_that_of_the_polygon(angle):
    tape = shapely.affinity.rotate(shapely.box(-0.1, -0.0251, 0.1, 0.0252), angle, use_radians=True)
    picture = paint(EXTENT, [FLOOR, Layer(tape, DARK)])
    # Grey levels are whole: each of the few hundred pixels on the edge is off by up to a half.
    assert dark_share(picture).sum() * 1e-6 == pytest.approx(tape.area, rel=1e-4)


@pytest.mark.parametrize("edge", np.linspace(0.01, 0.012, 9))
def test_an_edge_is_where_it_was_drawn_to_a_twentieth_of_a_millimetre(edge):
    picture = paint(EXTENT, [FLOOR, Layer(shapely.box(edge, -0.1, 0.1, 0.1), DARK)])
    profile = dark_share(picture)[50]
    # The half-way point of the profile, by counting how much is light left of the middle.
    middle = 300
    found = -0.2 + 0.001 * (1 - profile[:middle]).sum()
    assert found == pytest.approx(edge, abs=0.00002)


def test_a_slanted_edge_is_where_it_was_drawn():
    slope = 0.05
    tape = shapely.Polygon([(-0.2, -0.1), (0.2, -0.1), (0.2, 0.2 * slope), (-0.2, -0.2 * slope)])
    picture = paint(EXTENT, [FLOOR, Layer(tape, DARK)])
    found = -0.1 + 0.001 * dark_share(picture).sum(axis=0)
    drawn = slope * (np.arange(400) - 199.5) * 0.001
    assert np.abs(found - drawn).max() < 0.00002


def test_neighbouring_coats_of_one_paint_leave_no_seam():
    halves = [shapely.box(-0.2, -0.1, 0.0105, 0.1), shapely.box(0.0105, -0.1, 0.2, 0.1)]
    picture = paint(EXTENT, [FLOOR, *[Layer(half, DARK) for half in halves]])
    assert (picture.image == DARK).all()


def test_paint_that_lets_light_through_mixes():
    picture = paint(EXTENT, [FLOOR, Layer(shapely.box(*EXTENT), DARK, alpha=0.25)])
    assert (picture.image == 160).all()


def test_later_paint_covers_earlier_paint():
    box = shapely.box(-0.05, -0.05, 0.05, 0.05)
    picture = paint(EXTENT, [FLOOR, Layer(box, DARK), Layer(box, LIGHT)])
    assert (picture.image == LIGHT).all()


def test_paint_beyond_the_floor_is_cut_off():
    picture = paint(EXTENT, [Layer(shapely.box(-9, -9, 9, 9), DARK)])
    assert (picture.image == DARK).all()
    aside = paint(EXTENT, [FLOOR, Layer(shapely.box(5, 5, 9, 9), DARK)])
    assert (aside.image == LIGHT).all()


def test_the_border_is_the_tone_of_the_rim():
    picture = paint(EXTENT, [FLOOR, Layer(shapely.box(-0.2, 0.05, 0.0, 0.1), DARK)])
    assert picture.image[0, 0] == DARK
    assert picture.border == LIGHT


def test_grey_at_looks_into_the_pixel_around_a_point():
    picture = paint(EXTENT, [FLOOR, Layer(shapely.box(0.010, 0.020, 0.011, 0.021), DARK)])
    points = np.array([[0.01001, 0.02099], [0.01099, 0.02001], [0.00999, 0.0205], [5.0, 0.0]])
    assert grey_at(picture, points).tolist() == [DARK, DARK, LIGHT, LIGHT]


def test_a_picture_is_read_only():
    with pytest.raises(ValueError, match="read-only"):
        paint(EXTENT, [FLOOR]).image[0, 0] = 1


def test_an_extent_that_the_pixels_do_not_fill_is_refused():
    with pytest.raises(ValueError, match="do not cover"):
        FloorPicture(np.zeros((10, 10), np.uint8), 0.001, (0.0, 0.0, 0.01, 0.02))


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


@pytest.mark.parametrize("place", [(-5, 0), (9, 0), (0, -5), (0, 9), (-5, -5)])
def test_a_layer_beside_the_picture_paints_nothing(place):
    """Of the cells on which it could lie, no row or no column is left."""
    outside = shapely.box(*place, place[0] + 1.5, place[1] + 2.5)
    for shape in ((3, 4), (3, 0), (0, 4), (0, 0)):
        assert not coverage(outline(outside), shape).any()
    alone, both = paint(EXTENT, [FLOOR]), paint(EXTENT, [FLOOR, Layer(outside, DARK)])
    assert np.array_equal(alone.image, both.image)


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
