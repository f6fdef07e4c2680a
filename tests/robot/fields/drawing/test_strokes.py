"""Curves, strokes, dashes and fills, against what shapely or a formula says."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from robot.fields.drawing.curves import flatten
from robot.fields.drawing.strokes import Pen, Polyline, dashes, fill_area, stroke_area

TOLERANCE = 0.08
CORNER = Polyline(np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 80.0]]), closed=False)
SQUARE = Polyline(np.array([[0.0, 0.0], [100.0, 0.0], [100.0, 100.0], [0.0, 100.0]]), closed=True)


def circle(radius):
    def curve(parameters):
        angles = 2 * math.pi * parameters
        return radius * np.column_stack([np.cos(angles), np.sin(angles)])

    return curve


def bezier(points):
    def curve(parameters):
        t = parameters[:, None]
        weights = [(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3]
        return sum(w * p for w, p in zip(weights, points, strict=True))

    return curve


def apart(a, b):
    """The largest distance from a point of one outline to the other."""
    return max(
        shapely.distance(b.boundary, shapely.points(shapely.get_coordinates(near))).max()
        for a, b in ((a, b), (b, a))
        for near in [shapely.segmentize(a.boundary, 0.5)]
    )


@pytest.mark.parametrize("radius", [5.0, 30.0, 300.0, 5000.0])
@pytest.mark.parametrize("half_width", [0.0, 25.0])
def test_a_flattened_circle_and_its_parallels_are_within_the_tolerance(radius, half_width):
    points = flatten(circle(radius), half_width, TOLERANCE)
    middles = (points[1:] + points[:-1]) / 2
    sagitta = (radius + half_width) / radius * (radius - np.hypot(*middles.T))
    assert 0.3 * TOLERANCE < sagitta.max() < 1.05 * TOLERANCE


def test_a_straight_curve_becomes_one_line():
    points = flatten(bezier(np.array([[0.0, 0], [10, 5], [20, 10], [30, 15]])), 25, TOLERANCE)
    assert np.allclose(points, [[0, 0], [30, 15]])


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_flattened_bezier_is_within_the_tolerance(seed):
    corners = np.random.default_rng(seed).uniform(-300, 300, (4, 2))
    curve = bezier(corners)
    chain = shapely.LineString(flatten(curve, 0.0, TOLERANCE))
    exact = shapely.points(curve(np.linspace(0, 1, 3000)))
    assert shapely.distance(chain, exact).max() < 1.25 * TOLERANCE


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_curve_keeps_its_direction_at_its_ends(seed):
    corners = np.random.default_rng(seed).uniform(-300, 300, (4, 2))
    points = flatten(bezier(corners), 25.0, TOLERANCE)
    for chord, tangent in (
        (points[1] - points[0], corners[1] - corners[0]),
        (points[-1] - points[-2], corners[3] - corners[2]),
    ):
        sine = np.cross([*chord, 0], [*tangent, 0])[2]
        assert abs(sine) < 0.02 * math.hypot(*chord) * math.hypot(*tangent)


@pytest.mark.parametrize("cap", ["butt", "round", "square"])
@pytest.mark.parametrize("join", ["miter", "round", "bevel"])
def test_strokes_are_what_shapely_makes_of_them(cap, join):
    shapely_names = {"butt": "flat", "miter": "mitre"}
    expected = shapely.buffer(
        shapely.LineString(CORNER.points),
        10,
        quad_segs=64,
        cap_style=shapely_names.get(cap, cap),
        join_style=shapely_names.get(join, join),
    )
    area = stroke_area(CORNER, Pen(20, cap, join), 0.01)
    assert area.geom_type == "Polygon"
    assert apart(area, expected) < 0.02
    assert area.area == pytest.approx(expected.area, rel=2e-4)


def test_a_closed_square_is_mitred_at_all_corners():
    area = stroke_area(SQUARE, Pen(20), TOLERANCE)
    expected = shapely.box(-10, -10, 110, 110) - shapely.box(10, 10, 90, 90)
    assert area.symmetric_difference(expected).area < 1e-9


def test_a_corner_beyond_the_miter_limit_is_bevelled():
    sharp = Polyline(np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 20.0]]), closed=False)
    ratio = 1 / math.sin(math.atan(0.2) / 2)
    mitred = stroke_area(sharp, Pen(20, miter_limit=ratio + 0.01), TOLERANCE)
    bevelled = stroke_area(sharp, Pen(20, miter_limit=ratio - 0.01), TOLERANCE)
    tip = 100 + 10 * ratio * math.cos(math.atan(0.2) / 2)
    assert mitred.bounds[2] == pytest.approx(tip)
    assert bevelled.equals(stroke_area(sharp, Pen(20, join="bevel"), TOLERANCE))
    assert bevelled.bounds[2] < 103


def test_the_stroke_of_a_circle_is_a_ring():
    ring = Polyline(flatten(circle(300), 25, TOLERANCE)[:-1], closed=True)
    area = stroke_area(ring, Pen(50), TOLERANCE)
    exact = shapely.Point(0, 0).buffer(325, 2000) - shapely.Point(0, 0).buffer(275, 2000)
    assert apart(area, exact) < 0.1


def test_a_line_back_on_itself_is_round_at_its_turn():
    back = Polyline(np.array([[0.0, 0.0], [100.0, 0.0], [0.0, 0.0]]), closed=False)
    area = stroke_area(back, Pen(20, join="round"), 0.01)
    assert area.area == pytest.approx(2000 + math.pi * 50, rel=1e-3)


@pytest.mark.parametrize(("cap", "size"), [("butt", 0), ("round", math.pi * 100), ("square", 400)])
def test_a_line_of_no_length_is_a_dot_of_its_cap(cap, size):
    dot = Polyline(np.array([[5.0, 5.0], [5.0, 5.0]]), closed=False)
    assert stroke_area(dot, Pen(20, cap), 0.001).area == pytest.approx(size, rel=1e-3)


def test_a_tiny_kink_from_rounding_makes_no_spike():
    kinked = np.array([[0.0, 0.0], [50.0, 0.0], [50.0, 1e-9], [50.0 - 1e-9, 0.0], [100.0, 0.0]])
    area = stroke_area(Polyline(kinked, closed=False), Pen(20), TOLERANCE)
    assert area.bounds == pytest.approx((0, -10, 100, 10))


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["miter", "round", "bevel"]))
def test_a_stroke_covers_all_that_is_nearer_than_half_its_width(seed, join):
    rng = np.random.default_rng(seed)
    line = Polyline(rng.uniform(0, 100, (rng.integers(2, 8), 2)), closed=bool(rng.integers(2)))
    area = stroke_area(line, Pen(20, "round", join, miter_limit=1.0), 0.01)
    around = np.vstack([line.points, line.points[:1]]) if line.closed else line.points
    places = shapely.points(rng.uniform(-20, 120, (300, 2)))
    far = shapely.distance(shapely.LineString(around), places)
    inside = shapely.contains(area, places)
    assert not inside[far > 10].any()
    if join == "round":
        assert inside[far < 9.98].all()


def test_dashes_cut_a_line_in_the_pattern_from_the_offset():
    line = np.array([[0.0, 0.0], [10.0, 0.0]])
    pieces = dashes(line, closed=False, pattern=(3, 2), offset=1)
    assert [piece[:, 0].tolist() for piece in pieces] == [[0, 2], [4, 7], [9, 10]]


def test_an_odd_dash_pattern_is_repeated():
    line = np.array([[0.0, 0.0], [12.0, 0.0]])
    pieces = dashes(line, closed=False, pattern=(2,), offset=0)
    assert [piece[:, 0].tolist() for piece in pieces] == [[0, 2], [4, 6], [8, 10], [12, 12]]


def test_a_dash_bends_with_its_line():
    pieces = dashes(CORNER.points, closed=False, pattern=(20, 80), offset=90)
    assert pieces[0].tolist() == [[10, 0], [30, 0]]
    assert pieces[1].tolist() == [[100, 10], [100, 30]]


def test_dashes_that_meet_at_the_start_of_a_closed_line_are_one():
    pieces = dashes(SQUARE.points, closed=True, pattern=(50, 50), offset=25)
    assert len(pieces) == 4
    assert pieces[0].tolist() == [[0, 25], [0, 0], [25, 0]]


def test_a_pattern_without_length_draws_through():
    through = stroke_area(SQUARE, Pen(20), TOLERANCE)
    assert stroke_area(SQUARE, Pen(20, dashes=(0.0, 0.0)), TOLERANCE).equals(through)


@pytest.mark.parametrize("pattern", [(-1.0, 2.0), (1e-9,)])
def test_absurd_dashes_are_refused(pattern):
    with pytest.raises(ValueError, match="valid"):
        dashes(SQUARE.points, closed=True, pattern=pattern, offset=0)


def star():
    angles = math.pi / 2 + np.arange(5) * 4 * math.pi / 5
    return np.column_stack([np.cos(angles), np.sin(angles)])


def test_a_star_is_filled_by_winding_and_has_a_hole_by_even_and_odd():
    middle = shapely.Point(0, 0)
    assert shapely.contains(fill_area([star()], even_odd=False), middle)
    assert not shapely.contains(fill_area([star()], even_odd=True), middle)


@pytest.mark.parametrize(("inner", "area"), [(1, 16), (-1, 12)])
def test_an_inner_outline_is_a_hole_only_where_it_turns_the_other_way(inner, area):
    outer = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    hole = (outer / 2 + 1)[::inner]
    assert fill_area([outer, hole], even_odd=False).area == pytest.approx(area)
    assert fill_area([outer, hole], even_odd=True).area == pytest.approx(12)


def test_lines_without_an_inside_fill_nothing():
    assert fill_area([CORNER.points[:2]], even_odd=False).is_empty
    assert fill_area([np.array([[0.0, 0], [1, 1], [2, 2]])], even_odd=False).is_empty
    assert fill_area([], even_odd=False).is_empty
