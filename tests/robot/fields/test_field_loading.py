from pathlib import Path

import numpy as np
import pytest
from places import MAPS

from robot.fields.field import FieldError
from robot.fields.field_loading import field_names, load_field
from robot.fields.grid_map import save_map_yaml
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2


def test_the_programs_own_fields_are_found_by_name():
    assert {"square", "stub", "tee", "town"} <= set(field_names(MAPS))
    for name in field_names(MAPS):
        assert load_field(name, MAPS).name == name


def test_a_drawing_is_found_by_its_file():
    assert load_field(str(MAPS / "stub.svg"), Path("nowhere")).name == "stub"


@pytest.mark.parametrize("ending", [".yaml", ".yml"])
def test_a_ros_map_is_found_by_its_file(tmp_path, ending):
    grid = OccupancyGrid(np.array([[0, 100]], np.int8), 0.5, Pose2())
    save_map_yaml(grid, tmp_path / f"office{ending}")
    assert load_field(str(tmp_path / f"office{ending}"), MAPS).name == "office"


@pytest.mark.parametrize("name", ["sqare", "", "map.png", "no/such/place", ".", "..", "maps/"])
def test_an_unknown_name_lists_the_known_ones(name):
    with pytest.raises(FieldError, match=r"square, stub, stubs, tee, town.*svg or \.yaml file"):
        load_field(name, MAPS)


def test_an_absent_folder_of_fields_is_named(tmp_path):
    with pytest.raises(FieldError, match="none in"):
        load_field("square", tmp_path / "absent")


@pytest.mark.parametrize("name", ["absent.svg", "absent.yaml", "\0.svg", "\0.yaml", "\0"])
def test_an_absent_file_is_a_field_error(tmp_path, name):
    with pytest.raises(FieldError, match=r"no such file|cannot be read|valid are"):
        load_field(str(tmp_path / name), MAPS)
    with pytest.raises(FieldError):
        load_field(name, MAPS)


def test_a_ros_map_without_walls_is_a_field_error(tmp_path):
    save_map_yaml(OccupancyGrid(np.zeros((2, 2), np.int8), 0.5, Pose2()), tmp_path / "a.yaml")
    with pytest.raises(FieldError, match="no occupied cell"):
        load_field(str(tmp_path / "a.yaml"), MAPS)
