"""Fields from a seed: ordinary drawings, whatever the seed."""

import math

import numpy as np
import pytest
import shapely
from floor_looks import grey_at
from places import MAPS

from robot.fields.edges import lengths
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.fields.generator.generated import LARGEST, SMALLEST, drawing
from robot.fields.generator.names import MAX_SEED, generated_seed
from robot.fields.generator.strokes import BEND, bent, oval
from robot.fields.svg_field import field_of_drawing

pytestmark = pytest.mark.slow

MANY = range(100)
SOME = range(0, 100, 7)


def kinds(seed):
    title = drawing(seed).partition("<title>")[2].partition("</title>")[0]
    return title.partition(": ")[2].replace(",", "").split()


@pytest.fixture(scope="module")
def fields():
    return {seed: load_field(f"generated-{seed}", MAPS) for seed in SOME}


def test_the_same_seed_is_the_same_drawing_and_another_is_another():
    first = [drawing(seed) for seed in MANY]
    drawing.cache_clear()
    assert first == [drawing(seed) for seed in MANY]
    assert len(set(first)) == len(first)


def test_all_kinds_are_drawn():
    drawn = {kind for seed in range(300) for kind in kinds(seed)}
    outlines = {"rectangle", "square", "room", "rounded-room", "rounded", "ellipse", "streets"}
    marks = {"cross", "line", "bar", "stub", "dashes", "bends", "island"}
    assert outlines | marks | {"symmetric"} == drawn


def test_fields_are_as_large_as_they_should_be_with_free_floor_and_a_start_on_it(fields):
    for seed, field in fields.items():
        assert field.name == f"generated-{seed}"
        assert field.tape_width == pytest.approx(0.05)
        points = field.edges.reshape(-1, 2)
        size = np.ptp(points, axis=0)
        assert SMALLEST / 1000 * 0.7 < size.min() <= size.max() <= LARGEST / 1000 + 0.1, seed
        assert size.max() >= SMALLEST / 1000, seed
        start = np.array([[field.start.x, field.start.y]])
        assert grey_at(field.floor, start)[0] > 128, seed
        assert len(field.free_poses(np.random.default_rng(0), 3)) == 3
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        assert math.dist(start[0], middle) < 0.4 * np.hypot(*size), seed
        assert lengths(field.edges).min() > 1e-4, seed


def test_what_is_symmetric_looks_alike_after_half_a_turn(fields):
    alike = {seed: field for seed, field in fields.items() if "symmetric" in kinds(seed)}
    assert alike
    for seed, field in alike.items():
        rings = shapely.linestrings(field.edges.reshape(-1, 2, 2))
        all_edges = shapely.multilinestrings(rings)
        turned = shapely.transform(all_edges, np.negative)
        assert shapely.hausdorff_distance(all_edges, turned) < 2e-3, seed


@pytest.mark.parametrize(
    ("name", "seed"), [("generated-0", 0), (f"generated-{MAX_SEED}", MAX_SEED)]
)
def test_names_have_their_seed(name, seed):
    assert generated_seed(name) == seed


@pytest.mark.parametrize(
    "name", ["generated", "generated-", "generated--1", "generated-01", "generated-4294967296"]
)
def test_other_names_are_no_fields(name):
    assert generated_seed(name) is None
    with pytest.raises(FieldError, match="generated-0 to generated-4294967295"):
        load_field(name, MAPS)


def test_bends_run_as_their_path_says():
    """The points that keep lines apart, against the drawing as it is read."""
    strokes = [
        bent([(-600, -400), (0, -400), (200, 300), (600, 300)], 150),
        bent([(-500, -300), (500, -300), (500, 300), (-500, 300)], 200, closed=True).turned(),
        oval(100, 50, 400, 200),
    ]
    for one in strokes:
        page = f"""<svg xmlns="http://www.w3.org/2000/svg" viewBox="-1000 -1000 2000 2000">
        <g transform="scale(1 -1)" stroke="#000" fill="none" stroke-width="50">{one.element()}</g>
        </svg>"""
        edges = shapely.multilinestrings(field_of_drawing(page, "x").edges.reshape(-1, 2, 2))
        ours = shapely.transform(one.area, lambda points: points / 1000)
        assert shapely.hausdorff_distance(edges, ours.boundary) < 2.5e-3


def test_a_corner_without_room_for_a_bend_stays_sharp():
    assert "A" not in bent([(0, 0), (200, 0), (200, 200)], BEND + 50).path
    assert "A" in bent([(0, 0), (300, 0), (300, 300)], BEND + 50).path
