"""Keep-out zones and tape: what is said of walls is what the robot keeps away from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.settings.config import MAPS
from robot.description.spec import RobotSpec
from robot.fields.field_loading import load_field
from robot.navigation.free_space import INSCRIBED, LETHAL, FreeSpace
from robot.navigation.settings import NavigationSettings
from robot.navigation.walls import NOTE, Walls

ZONE = ((0.1, 0.1), (0.3, 0.1), (0.3, 0.2), (0.1, 0.2))
SETTINGS = NavigationSettings()
OUTLINE = RobotSpec.load().outline
TAPE = np.array([[0.5, 0.0]])


@pytest.fixture(scope="module")
def square():
    return load_field("square", MAPS)


def test_a_zone_is_a_wall_and_beside_it_the_floor_is_free(square):
    space = FreeSpace.of(square, OUTLINE, SETTINGS, Walls(zones=(ZONE,)))
    inside, beside = space.clearance(np.array([[0.2, 0.15], [0.2, 0.25]]))
    assert inside == 0
    assert beside == pytest.approx(0.05, abs=0.003)
    free = FreeSpace.of(square, OUTLINE, SETTINGS)
    assert free.clearance(np.array([[0.2, 0.15]]))[0] > 0.1


@pytest.mark.parametrize(
    ("note", "setting", "said", "ignored"),
    [
        (None, "wall", None, False),
        (None, "ignored", None, True),
        ("ignored", "wall", None, True),
        ("wall", "ignored", None, False),
        ("glue", "ignored", None, True),
        ("ignored", "ignored", "wall", False),
        ("wall", "wall", "ignored", True),
    ],
)
def test_who_says_last_whether_tape_is_a_wall(square, note, setting, said, ignored):
    field = replace(square, notes={NOTE: note} if note else {})
    settings = replace(SETTINGS, tape=setting)
    assert Walls(said).ignore_tape(field, settings) == ignored
    space = FreeSpace.of(field, OUTLINE, settings, Walls(said))
    assert (space.clearance(TAPE)[0] > 0) == ignored


def test_the_layer_has_the_numbers_of_nav2(square):
    space = FreeSpace.of(square, OUTLINE, SETTINGS, Walls(zones=(ZONE,)))
    layer = space.layer()
    assert layer.shape == space.costs.shape
    assert layer[space.cell(0.2, 0.15)] == LETHAL
    assert layer[space.cell(0.2, 0.22)] == INSCRIBED
    np.testing.assert_array_equal(layer >= INSCRIBED, np.isinf(space.costs))
    # Away from the zone the cost falls, and ends where the inflation does.
    column = space.cell(0.2, 0.0)[1]
    falling = layer[: space.cell(0.2, 0.0)[0], column].astype(int)
    assert 0 <= layer.min() < falling.max()
    far = FreeSpace.of(square, OUTLINE, replace(SETTINGS, inflation_radius=0.0)).layer()
    assert set(np.unique(far)) <= {0, INSCRIBED, LETHAL}


@given(st.lists(st.tuples(st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)), min_size=3, max_size=8))
def test_any_corners_make_cells_and_each_corner_on_the_floor_is_one(corners):
    touched = Walls(zones=(tuple(corners),)).cells((-1.0, -1.0), 0.1, (20, 20))
    assert touched.shape == (20, 20)
    near = [(x, y) for x, y in corners if -0.95 < x < 0.95 and -0.95 < y < 0.95]
    if len(near) == len(corners):
        for x, y in near:
            row, column = round((y + 1) / 0.1 - 0.5), round((x + 1) / 0.1 - 0.5)
            around = touched[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2]
            assert around.any()
