import math

import numpy as np
import pytest
import shapely
from floor_looks import grey_at
from places import MAPS

from robot.fields.edges import outline
from robot.fields.field import Field, FieldError
from robot.fields.field_loading import load_field
from robot.fields.floor_picture import Layer, paint
from robot.fields.grid_field import field_from_grid
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2
from robot.scanning.tape import Tape

EXTENT = (-0.5, -0.25, 0.5, 0.25)
BAR = shapely.box(-0.3, -0.05, 0.3, 0.05)


def bar_field(start=Pose2(0.0, 0.2, 0.0), edges=None):
    floor = paint(EXTENT, [Layer(BAR, 30)])
    return Field("bar", floor, outline(BAR) if edges is None else edges, (Tape(0.1),), start)


def ring_field():
    """A frame of tape with dark clutter inside that is in no edge map."""
    frame = shapely.box(-0.4, -0.2, 0.4, 0.2) - shapely.box(-0.35, -0.15, 0.35, 0.15)
    clutter = shapely.box(0.1, -0.1, 0.3, 0.1)
    floor = paint(EXTENT, [Layer(frame, 30), Layer(clutter, 60)])
    return Field("ring", floor, outline(frame), (Tape(0.05),), Pose2())


def test_a_pose_off_the_field_is_refused_with_what_is_valid():
    field = bar_field()
    field.require_inside(Pose2(0.5, -0.25, 3.0))
    with pytest.raises(FieldError, match=r"\(0.600, 0.000\) m.*bar; valid is x -0.500 to 0.500, y"):
        field.require_inside(Pose2(0.6, 0.0, 0.0))


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_a_pose_that_is_not_finite_is_not_on_the_field(bad):
    assert not bar_field().contains(Pose2(bad, 0, 0))
    assert not bar_field().contains(Pose2(0, bad, 0))


def test_a_start_off_the_field_is_refused():
    with pytest.raises(FieldError, match="not on the field"):
        bar_field(start=Pose2(9, 9, 0))


@pytest.mark.parametrize("edges", [np.empty((0, 4)), np.zeros((2, 3)), np.full((1, 4), np.nan)])
def test_edges_that_are_none_are_refused(edges):
    with pytest.raises(FieldError, match="edges"):
        bar_field(edges=edges)


def test_a_field_cannot_be_changed():
    field = bar_field()
    with pytest.raises(ValueError, match="read-only"):
        field.edges[0] = 0
    with pytest.raises(AttributeError):
        field.name = "other"


def test_tape_becomes_occupied_cells_over_the_whole_floor():
    grid = bar_field().occupancy(0.1)
    expected = np.zeros((5, 10), np.int8)
    expected[2, 2:8] = 100
    assert grid.data.tolist() == expected.tolist()
    assert grid.origin == Pose2(-0.5, -0.25, 0.0)


def test_half_covered_cells_are_occupied_on_both_sides():
    grid = bar_field().occupancy(0.05)
    assert (grid.data == 100).sum() == 2 * 12
    coarse = bar_field(Pose2()).occupancy(0.25)
    assert coarse.data.tolist() == [[0] * 4] * 2


@pytest.mark.parametrize("resolution", [0.001, 0.003, 0.0071, 0.0131])
def test_the_occupied_area_is_that_of_the_tape(resolution):
    field = load_field("town", MAPS)
    grid, edges = field.occupancy(resolution), field.edges
    area = (edges[:, 0] * edges[:, 3] - edges[:, 2] * edges[:, 1]).sum() / 2
    assert grid.occupied.sum() * resolution**2 == pytest.approx(area, rel=0.02)


@pytest.mark.parametrize("resolution", [0.0, -1.0, float("nan"), float("inf"), 1e-9])
def test_an_absurd_resolution_is_refused(resolution):
    with pytest.raises(FieldError, match="valid"):
        bar_field().occupancy(resolution)


def test_the_grid_of_a_ros_map_comes_back_at_its_own_resolution():
    data = np.array([[100, 0, -1], [0, 0, 50]], np.int8)
    field = field_from_grid(OccupancyGrid(data, 0.1, Pose2(1, 2, 0)), "map")
    again = field.occupancy(0.1)
    assert again.data.tolist() == data.tolist()
    assert (again.resolution, again.origin) == (0.1, Pose2(1, 2, 0))
    assert field.occupancy(0.05).data[::2, ::2].tolist() == data.tolist()


def test_free_poses_are_spread_evenly_over_the_light_floor_between_tape():
    field = ring_field()
    poses = field.free_poses(np.random.default_rng(5), 40_000)
    assert poses.shape == (40_000, 3)
    x, y, theta = poses.T
    assert (grey_at(field.floor, poses[:, :2]) >= 128).all()
    assert np.abs(x).max() <= 0.4
    assert np.abs(y).max() <= 0.2
    assert (theta >= -math.pi).all()
    assert (theta < math.pi).all()
    # 0.7 x 0.3 m inside, less 0.2 x 0.2 m of clutter; the left half has 0.105 m2 of it.
    assert (x < 0).mean() == pytest.approx(0.105 / 0.17, abs=0.01)
    assert (theta < 0).mean() == pytest.approx(0.5, abs=0.01)
    assert np.histogram(y[x < 0], 5, (-0.15, 0.15))[0] / (x < 0).sum() == pytest.approx(
        0.2, abs=0.015
    )


def test_free_poses_reach_up_to_the_tape():
    poses = load_field("square", MAPS).free_poses(np.random.default_rng(1), 20_000)
    assert np.abs(poses[:, :2]).max(axis=0) == pytest.approx([0.475, 0.475], abs=0.001)


def test_free_poses_of_a_ros_map_lie_in_its_free_cells():
    data = np.array([[100, 0, -1], [0, 30, 100]], np.int8)
    grid = OccupancyGrid(data, 0.1, Pose2(1, 2, 0.7))
    poses = field_from_grid(grid, "map").free_poses(np.random.default_rng(2), 1000)
    assert (grid.values_at(poses[:, :2]) == 0).all()


def test_the_same_seed_draws_the_same_poses():
    field = load_field("stub", MAPS)
    draws = [field.free_poses(np.random.default_rng(3), 10) for _ in range(2)]
    assert (draws[0] == draws[1]).all()


def test_where_tape_encloses_nothing_a_robot_is_beside_it(tmp_path):
    path = tmp_path / "line.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="2000mm" height="1000mm" '
        'viewBox="-1000 -500 2000 1000">'
        '<path d="M -700 0 H 700" stroke="black" stroke-width="50"/></svg>'
    )
    line = load_field(str(path), MAPS)
    assert line.drive_area == line.extent == (-1.0, -0.5, 1.0, 0.5)
    poses = line.free_poses(np.random.default_rng(4), 2000)
    assert poses[:, :2].min(axis=0) == pytest.approx([-1, -0.5], abs=0.02)
    assert poses[:, :2].max(axis=0) == pytest.approx([1, 0.5], abs=0.02)
    assert load_field("square", MAPS).drive_area == (-0.525, -0.525, 0.525, 0.525)


def test_a_drawing_that_is_all_tape_is_refused(tmp_path):
    path = tmp_path / "night.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" '
        'viewBox="0 0 100 100"><rect width="100" height="100" fill="black"/></svg>'
    )
    with pytest.raises(FieldError, match=r"night"):
        load_field(str(path), MAPS)


def test_a_field_without_light_floor_says_so():
    floor = paint(EXTENT, [Layer(shapely.box(*EXTENT), 20)])
    field = Field("night", floor, outline(BAR), (Tape(0.1),), Pose2())
    with pytest.raises(FieldError, match="no free floor"):
        field.free_poses(np.random.default_rng(0), 1)
