"""How far places are from walls, and where a robot fits."""

import numpy as np
import pytest

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field import Field
from robot.fields.field_loading import load_field
from robot.fields.grid_field import field_from_grid
from robot.fields.occupancy_grid import OccupancyGrid
from robot.fields.svg_field import field_of_drawing
from robot.geometry import Pose2
from robot.navigation.free_space import FreeSpace
from robot.navigation.settings import NavigationSettings

OUTLINE = RobotSpec.load().outline
HALF = 0.475
"""Half the width between the tape's inner edges of the square [m]."""


@pytest.fixture(scope="module")
def square() -> Field:
    return load_field("square", MAPS)


@pytest.fixture(scope="module")
def free(square) -> FreeSpace:
    return FreeSpace.of(square, OUTLINE, NavigationSettings())


def test_the_distance_to_tape_is_right_to_two_millimetres(free):
    places = np.array([[0.0, 0.0], [0.2, 0.1], [0.4, -0.3], [-0.47, 0.0]])
    right = HALF - np.abs(places).max(axis=1)
    assert free.clearance(places) == pytest.approx(right, abs=0.002)


def test_tape_and_what_is_beyond_the_floor_are_no_room(free):
    assert free.clearance(np.array([[0.5, 0.0], [0.9, 0.0], [0.0, -7.0]])).tolist() == [0, 0, 0]


def test_outside_of_the_ring_is_floor_again(free):
    assert free.clearance(np.array([[0.64, 0.0]]))[0] == pytest.approx(0.11, abs=0.003)


@pytest.mark.parametrize("theta", [0.0, 0.7, 2.0, -2.6])
def test_the_whole_outline_has_to_fit(free, theta):
    """A pose fits if and only if each corner of the outline is so far from the tape."""
    needed = free.settings.clearance
    for x in np.linspace(0.3, 0.45, 31):
        pose = Pose2(float(x), 0.0, theta)
        room = HALF - np.abs(pose.apply(OUTLINE)).max()
        if abs(room - needed) > 0.003:
            assert free.fits(pose.to_array()[None]) == (room > needed), (x, theta)


def test_ignored_tape_is_floor_and_the_floor_still_ends(square):
    ignoring = FreeSpace.of(square, OUTLINE, NavigationSettings(tape="ignored"))
    places = np.array([[0.0, 0.0], [0.5, 0.0], [0.7, 0.0]])
    assert ignoring.clearance(places) == pytest.approx([0.75, 0.25, 0.05], abs=0.003)


def test_a_dark_shape_stands_there_though_tape_is_ignored():
    drawing = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="1000mm" height="1000mm" '
        'viewBox="-500 -500 1000 1000"><rect x="-500" y="-500" width="1000" height="1000" '
        'fill="#ddd"/><line x1="-300" y1="-300" x2="300" y2="-300" stroke="#111" '
        'stroke-width="30"/><rect x="100" y="-50" width="100" height="100" fill="#111"/></svg>'
    )
    field = field_of_drawing(drawing, "box")
    space = FreeSpace.of(field, OUTLINE, NavigationSettings(tape="ignored"))
    found = space.clearance(np.array([[0.15, 0.0], [0.0, 0.0], [0.0, 0.3]]))
    assert found == pytest.approx([0.0, 0.1, 0.2], abs=0.004)


def test_what_is_unknown_on_a_ros_map_is_a_wall():
    cells = np.zeros((40, 60), np.int8)
    cells[:, :3], cells[:3] = 100, -1
    space = FreeSpace.of(
        field_from_grid(OccupancyGrid(cells, 0.05, Pose2(1.0, 2.0)), "hall"),
        OUTLINE,
        NavigationSettings(),
    )
    found = space.clearance(np.array([[1.07, 3.0], [2.5, 2.07], [2.0, 3.0]]))
    assert found == pytest.approx([0.0, 0.0, 0.85], abs=0.05)


def test_costs_are_walls_near_tape_and_fall_away_from_it(free):
    row, column = free.cell(0.0, 0.0)
    along = free.costs[row, column:]
    reach = int(np.isfinite(along).sum())
    room = HALF - free.radius - free.settings.clearance
    assert reach * free.settings.resolution == pytest.approx(room, abs=0.012)
    assert (np.diff(along[:reach]) >= 0).all()
    assert along[0] == 1.0
    assert along[reach - 1] > 5.0
