import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from costs import processor_seconds
from floor_looks import grey_at
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from places import SHARED

from robot.fields.edges import lengths, sample
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.fields.grid_field import field_from_grid
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2

REAL = SHARED / "maps"
TURNED = Pose2(2.0, 3.0, 1.0)


def room(origin=Pose2()):
    """A room of 9 x 7 cells of 0.1 m within walls, and one unknown corner."""
    data = np.full((9, 11), 100, np.int8)
    data[1:-1, 1:-1] = 0
    data[1, 1] = -1
    return OccupancyGrid(data, 0.1, origin)


def test_walls_are_the_dark_side_of_edges():
    field = field_from_grid(room(), "room")
    assert field.tape_width is None
    assert len(field.edges) == 8
    assert sorted(lengths(field.edges)) == pytest.approx([0.7, 0.7, 0.9, 0.9, 0.9, 0.9, 1.1, 1.1])
    inner = field.edges[(np.abs(field.edges - [0.55, 0.45, 0.55, 0.45]) < 0.451).all(axis=1)]
    middles = (inner[:, :2] + inner[:, 2:]) / 2
    assert len(inner) == 4
    toward_light = field.normals[(field.edges[:, None] == inner).all(axis=2).any(axis=1)]
    assert (((np.array([0.55, 0.45]) - middles) * toward_light).sum(axis=1) > 0).all()


def test_the_start_is_the_roomiest_free_place():
    field = field_from_grid(room(), "room")
    # Rows 1 to 7 are free: row 4 has most room; of its columns those 3 cells from both ends.
    assert field.start.y == pytest.approx(0.45)
    assert 0.35 <= field.start.x <= 0.75


@settings(deadline=None)
@given(arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=7),
              elements=st.sampled_from([-1, 0, 30, 64, 65, 100])),
       st.floats(-3.1, 3.1))  # fmt: skip
def test_edges_separate_occupied_cells_from_others_at_any_heading(data, heading):
    grid = OccupancyGrid(data, 0.05, Pose2(-4.0, 7.0, heading))
    if not grid.occupied.any() or not grid.free.any():
        with pytest.raises(FieldError, match="has no"):
            field_from_grid(grid, "grid")
        return
    field = field_from_grid(grid, "grid")
    points, across = sample(field.edges, 0.05)
    assert (grid.values_at(points - 0.01 * across) >= 65).all()
    assert (grid.values_at(points + 0.01 * across) < 65).all()
    assert grid.values_at(np.array([[field.start.x, field.start.y]]))[0] in (0, 25)
    assert field.start.theta == pytest.approx(heading)


@pytest.mark.parametrize("origin", [Pose2(), Pose2(1.0, -2.0, 0.0), TURNED, Pose2(0, 0, -2.5)])
def test_the_floor_shows_the_cells_where_they_are(origin):
    field = field_from_grid(room(origin), "room")
    rows, columns = np.mgrid[0:9, 0:11] + 0.5
    centres = origin.apply(np.column_stack([columns.ravel(), rows.ravel()]) * 0.1)
    around = np.vstack([centres + offset for offset in ([0, 0], [0.03, 0.03], [-0.03, 0.03])])
    tones = {100: 0, 0: 254, -1: 205}
    expected = np.tile([tones[value] for value in room().data.ravel()], 3)
    assert (grey_at(field.floor, around) == expected).all()


def test_floor_and_edges_agree_to_a_millimetre_in_a_turned_map():
    field = field_from_grid(room(TURNED), "room")
    points, across = sample(field.edges, 0.01)
    assert (grey_at(field.floor, points - 0.0015 * across) == 0).all()
    assert (grey_at(field.floor, points + 0.0015 * across) > 200).all()


def test_around_a_turned_map_nothing_is_known():
    field = field_from_grid(room(TURNED), "room")
    assert field.floor.image[0, 0] == field.floor.image[-1, -1] == field.floor.border == 205


def test_thin_walls_of_a_large_map_stay_visible():
    data = np.zeros((100, 30_000), np.int8)
    data[:, ::50] = 100
    field = field_from_grid(OccupancyGrid(data, 1.0, Pose2()), "large")
    assert field.floor.resolution > 0.4
    wall, floor = grey_at(field.floor, np.array([[15_000.5, 50.0], [15_025.5, 50.0]]))
    assert wall < floor
    dense = np.zeros((4000, 6000), np.int8)
    dense[:, ::50] = 100
    picture = field_from_grid(OccupancyGrid(dense, 0.01, Pose2()), "dense").floor
    assert picture.resolution > 0.012
    row = picture.image[100].astype(int)
    assert (np.diff(np.flatnonzero(row < 200)) < 45).all()


def test_four_million_cells_take_less_than_two_seconds():
    rng = np.random.default_rng(0)
    noise = cv2.GaussianBlur(rng.normal(size=(2048, 2048)), (0, 0), 6)
    data = np.where(noise > 0.03, 100, 0).astype(np.int8)
    grid = OccupancyGrid(data, 0.05, TURNED)
    fields = []
    assert processor_seconds(lambda: fields.append(field_from_grid(grid, "caves"))) < 2
    assert len(fields[0].edges) > 50_000


@pytest.mark.data
@pytest.mark.skipif(not REAL.is_dir(), reason="needs the recorded maps")
@pytest.mark.parametrize(
    "name", ["tb3/map", "f1tenth/berlin", "f1tenth/levine", "nav2/depot", "nav2/testmap"]
)
def test_real_maps_are_fields(name):
    field = load_field(str(REAL / f"{name}.yaml"), Path("maps"))
    grid = field.grid
    assert field.name == Path(name).name
    assert field.contains(field.start)
    poses = field.free_poses(np.random.default_rng(1), 500)
    assert (grid.values_at(poses[:, :2]) == 0).all()
    walls = lengths(field.edges).sum() / grid.resolution
    assert walls == pytest.approx(round(walls))
    assert math.isfinite(walls)
