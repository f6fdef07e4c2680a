"""The maps that come with the program."""

import math

import numpy as np
import pytest
import shapely
from costs import processor_seconds
from floor_looks import grey_at
from places import MAPS

from robot.fields.edges import lengths
from robot.fields.svg_field import load_svg
from robot.geometry import Pose2


def tape(field):
    """The dark polygons: faces between edges that lie to the left of the edge next to them."""
    lines = shapely.linestrings(field.edges.reshape(-1, 2, 2))
    dark = []
    for face in shapely.get_parts(shapely.polygonize(lines)):
        inside = face.point_on_surface()
        nearest = shapely.distance(lines, inside).argmin()
        offset = [inside.x, inside.y] - field.edges[nearest, :2]
        if offset @ field.normals[nearest] < 0:
            dark.append(face)
    return shapely.union_all(dark)


def test_the_square_has_eight_edges_around_50_mm_of_tape():
    field = load_svg(MAPS / "square.svg")
    assert field.name == "square"
    assert field.tape_width == pytest.approx(0.05)
    assert field.start == Pose2()
    assert field.floor.extent == pytest.approx((-0.75, -0.75, 0.75, 0.75))
    assert len(field.edges) == 8
    assert sorted(lengths(field.edges).round(9)) == [0.95] * 4 + [1.05] * 4
    assert sorted(np.abs(field.edges).max(axis=1).round(9)) == [0.475] * 4 + [0.525] * 4


def test_the_square_is_dark_to_the_left_of_its_edges():
    field = load_svg(MAPS / "square.svg")
    middles = (field.edges[:, :2] + field.edges[:, 2:]) / 2
    assert (grey_at(field.floor, middles + 0.01 * field.normals) == field.floor.border).all()
    assert (grey_at(field.floor, middles - 0.01 * field.normals) < 60).all()


@pytest.mark.parametrize(("name", "edges", "mark"), [("stub", 12, 0.3), ("tee", 16, 0.7)])
def test_marked_squares_have_so_much_more_tape(name, edges, mark):
    square, marked = load_svg(MAPS / "square.svg"), load_svg(MAPS / f"{name}.svg")
    assert len(marked.edges) == edges
    more = tape(marked).area - tape(square).area
    assert more == pytest.approx(mark * 0.05)
    assert tape(marked).covers(tape(square).buffer(-1e-6))


def test_the_town_has_crossings_bends_and_islands():
    field = load_svg(MAPS / "town.svg")
    area = tape(field)
    assert field.tape_width == pytest.approx(0.05)
    assert len(shapely.get_parts(area)) >= 4  # the streets, and islands apart from them
    assert sum(len(part.interiors) for part in area.geoms) >= 10
    xmin, ymin, xmax, ymax = area.bounds
    assert (xmax - xmin, ymax - ymin) == pytest.approx((2.0, 2.0))
    assert len(field.edges) < 2000


def test_a_figure_eight_from_the_towns_start_stays_clear_of_tape():
    field = load_svg(MAPS / "town.svg")
    edges = shapely.multilinestrings(field.edges.reshape(-1, 2, 2))
    start = np.array([field.start.x, field.start.y])
    assert shapely.distance(edges, shapely.points(start)) > 0.25
    aside = 0.19 * np.array([-math.sin(field.start.theta), math.cos(field.start.theta)])
    for centre in (start + aside, start - aside):
        assert shapely.distance(edges, shapely.Point(centre).buffer(0.19)) > 0.04


@pytest.mark.parametrize("name", ["square", "stub", "tee", "town"])
def test_the_floor_goes_on_beyond_the_tape(name):
    field = load_svg(MAPS / f"{name}.svg")
    xmin, ymin, xmax, ymax = field.floor.extent
    points = field.edges.reshape(-1, 2)
    assert (points.min(axis=0) >= [xmin + 0.2, ymin + 0.2]).all()
    assert (points.max(axis=0) <= [xmax - 0.2, ymax - 0.2]).all()
    assert grey_at(field.floor, np.array([[field.start.x, field.start.y]]))[0] > 200


@pytest.mark.parametrize(("name", "seconds"), [("square", 0.3), ("town", 1.0)])
def test_loading_is_quick(name, seconds):
    load_svg(MAPS / "square.svg")
    best = min(processor_seconds(lambda: load_svg(MAPS / f"{name}.svg")) for _ in range(3))
    assert best < seconds
