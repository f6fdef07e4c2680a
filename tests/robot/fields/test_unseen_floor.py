"""Rays know where they leave the floor that was looked at."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from app.settings.config import MAPS
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.fields.svg_field import field_of_drawing
from robot.fields.unseen_floor import REACH, SIDE, UnseenFloor, seen_until
from robot.geometry import Pose2
from robot.localization.ray_evidence import AT_BORDER, RayEvidence, ends_of_seen
from robot.mapping.seen_floor import GOES_ON, SeenFloor
from robot.scan import Scan, rays_of

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
HOLE = np.array([[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]])
TAPE = 'stroke="#222" stroke-width="50" fill="none"'
LEFT = np.array([[-0.7, -0.7], [0.2, -0.7], [0.2, 0.7], [-0.7, 0.7]])
MIDDLE = Pose2(0.1, 0.0, 0.0)
MARGIN = (REACH + 2.5) * SIDE
"""Between what counts as seen and the outlines."""


def page(attributes=""):
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 400 300" {attributes}>'
        f'<line x1="100" y1="100" x2="300" y2="100" {TAPE}/></svg>'
    )


def test_without_outlines_all_of_the_floor_is_known():
    assert math.isinf(seen_until(5.0, 5.0, 1.0, 0.0, 9.0, UnseenFloor.beyond(())))


@given(st.floats(0.1, 0.9), st.floats(0.1, 0.9), st.floats(-math.pi, math.pi))
def test_a_ray_leaves_the_seen_floor_where_it_leaves_the_outline(x, y, heading):
    floor = UnseenFloor.beyond((SQUARE, HOLE))
    inside = shapely.Polygon(SQUARE, [HOLE])
    if shapely.distance(shapely.Point(x, y), inside.boundary) < MARGIN:
        return
    if not inside.contains(shapely.Point(x, y)):
        assert seen_until(x, y, 1.0, 0.0, 3.0, floor) == 0.0
        return
    dx, dy = math.cos(heading), math.sin(heading)
    left = seen_until(x, y, dx, dy, 3.0, floor)
    before, beyond = (shapely.Point(x + far * dx, y + far * dy) for far in (left - SIDE, left))
    assert inside.buffer(MARGIN).contains(before)
    assert not inside.buffer(-SIDE).contains(beyond)
    walked = shapely.LineString([(x, y), (x + left * dx, y + left * dy)])
    assert shapely.length(walked.difference(inside.buffer(MARGIN))) < 1e-9


def test_a_ray_that_ends_before_says_nothing_of_unseen_floor():
    floor = UnseenFloor.beyond((SQUARE,))
    assert math.isinf(seen_until(0.5, 0.5, 1.0, 0.0, 0.3, floor))


def test_a_drawing_says_what_was_looked_at():
    field = field_of_drawing(page('data-seen="0 0 400 0 400 300; 10 10 20 10 20 20"'), "it")
    assert [outline.tolist() for outline in field.seen] == [
        [[0, 0], [0.4, 0], [0.4, 0.3]],
        [[0.01, 0.01], [0.02, 0.01], [0.02, 0.02]],
    ]
    assert field_of_drawing(page(), "it").seen == ()


@pytest.mark.parametrize(
    "text", ["1 2", "1 2 3 4 5", "a b c d e f", "0 0 1 1; 2 2 3 3 4 4", "0 0;"]
)
def test_outlines_that_are_none_are_refused(text):
    with pytest.raises(FieldError, match=r"data-seen has .* three corners"):
        field_of_drawing(page(f'data-seen="{text}"'), "it")


@pytest.mark.parametrize("text", ["0 0 1e9 0 0 1", "0 0 1e308 0 0 -1e308", "0 0 1 1 nan 0"])
def test_outlines_beyond_all_floors_are_refused(text):
    with pytest.raises(FieldError, match="data-seen"):
        field_of_drawing(page(f'data-seen="{text}"'), "it")


def test_a_long_narrow_floor_takes_no_more_memory_than_a_wide_one():
    strip = np.array([[0, 0], [1000, 0], [1000, 0.1], [0, 0.1]])
    floor = UnseenFloor.beyond((strip,))
    assert max(floor.seen.shape) < 2100
    assert math.isinf(seen_until(1.0, 0.05, 1.0, 0.0, 500.0, floor))


def half_seen(*seen):
    """*square* as it is, and without its right side, of which these outlines were looked at."""
    whole = load_field("square", MAPS)
    kept = whole.edges[(whole.edges[:, [0, 2]] < 0.2).all(axis=1)]
    return whole, replace(whole, edges=np.ascontiguousarray(kept), seen=seen)


def scan_of(field):
    """What a robot in the middle sees of the right side of a field."""
    bearings = np.radians(np.linspace(-25, 25, 31))
    ranges = field.ranges(MIDDLE.to_array()[None], bearings, 1.0)[0]
    assert np.isfinite(ranges).all()
    return Scan(0.0, bearings, ranges)


def test_tape_on_unseen_floor_is_neither_due_nor_forbidden():
    """At the true pose, a scan of tape that was never drawn is worth as much as a bad place."""
    whole, part = half_seen()
    _, told = half_seen(LEFT)
    rays = rays_of(scan_of(whole), 31)
    of_whole, of_part, of_told = (
        RayEvidence.of(field, 1.0, 0.005).log_likelihood(MIDDLE, rays)
        for field in (whole, part, told)
    )
    assert of_part < of_whole - 5
    badly = RayEvidence.of(told, 1.0, 0.005).background_log_likelihood(rays)
    assert of_told == pytest.approx(badly)


def ends(field, scan):
    return ends_of_seen(MIDDLE.to_array(), rays_of(scan, 31), RayEvidence.of(field, 1.0, 0.005))


def test_a_ray_that_returns_from_unseen_floor_ends_where_that_begins():
    whole, told = half_seen(LEFT)
    scan = scan_of(whole)
    border = (LEFT[:, 0].max() - MIDDLE.x) / np.cos(scan.bearings)
    np.testing.assert_allclose(ends(told, scan), border - AT_BORDER, atol=MARGIN + SIDE)
    assert not scan.until(ends(told, scan)).hit.any()
    assert np.isinf(ends(half_seen()[1], scan)).all(), "all of the floor is known"


def test_an_edge_that_was_seen_behind_unseen_floor_counts():
    whole, _ = half_seen()
    behind = np.array([[0.35, -0.7], [0.7, -0.7], [0.7, 0.7], [0.35, 0.7]])
    told = replace(whole, seen=(LEFT, behind))
    scan = scan_of(whole)
    assert np.isinf(ends(told, scan)).all()
    evidence = RayEvidence.of(told, 1.0, 0.005)
    of_whole = RayEvidence.of(whole, 1.0, 0.005).log_likelihood(MIDDLE, rays_of(scan, 31))
    assert evidence.log_likelihood(MIDDLE, rays_of(scan, 31)) == pytest.approx(of_whole)
    # Nobody saw these edges: there the drawing ends, and the tape goes on.
    assert np.isfinite(ends(replace(whole, seen=(LEFT,)), scan)).all()


def test_tape_along_the_border_of_seen_floor_may_be_unseen():
    """Rays along a border leave the seen floor late, but tape beside them was not looked at."""
    floor = np.array([[0.2, -0.3], [0.7, -0.3], [0.7, 0.3], [0.2, 0.3]])
    evidence = RayEvidence.of(half_seen(floor)[1], 1.0, 0.005)
    rays = rays_of(Scan(0.0, np.zeros(1), np.array([0.2])), 1)
    along, inside = (ends_of_seen(np.array([0.25, y, 0.0]), rays, evidence)[0] for y in (0.3, 0.0))
    assert along == pytest.approx(0.2 - AT_BORDER)
    assert math.isinf(inside)


def test_around_open_ends_the_floor_is_not_seen():
    floor = SeenFloor((SQUARE,))
    whole, opened = (
        UnseenFloor.beyond(outlines)
        for outlines in map(floor.outlines, (np.empty((0, 2)), np.array([[0.5, 0.5]])))
    )
    assert math.isinf(seen_until(0.1, 0.5, 1.0, 0.0, 0.8, whole))
    far = 0.4 - GOES_ON + REACH * SIDE
    assert seen_until(0.1, 0.5, 1.0, 0.0, 0.8, opened) == pytest.approx(far, abs=2 * SIDE)
    assert math.isinf(seen_until(0.1, 0.8, 1.0, 0.0, 0.8, opened))
