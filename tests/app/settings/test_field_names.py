"""Which fields the page can load: drawings, saved maps, and what features make by name."""

from pathlib import Path

import numpy as np
import pytest
from places import MAPS

from app.engine.plugging import plug_in, plugged
from app.feature_search import find_features
from app.foreign_files import read_apart
from app.settings.field_names import field_named, listed_fields
from robot.errors import CommandError
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.fields.grid_map import save_map_yaml
from robot.fields.occupancy_grid import OccupancyGrid
from robot.geometry import Pose2


@pytest.fixture(autouse=True)
def put_back():
    """What takes part is as it was, afterwards."""
    before = plugged().features
    plug_in(find_features())
    yield
    plug_in(before)


@pytest.fixture
def saved(tmp_path):
    """A folder with a map that was saved, and one of ROS."""
    (tmp_path / "kitchen.svg").write_bytes((MAPS / "square.svg").read_bytes())
    grid = OccupancyGrid(np.array([[0, 100]], np.int8), 0.5, Pose2())
    save_map_yaml(grid, tmp_path / "office.yaml")
    return tmp_path


def test_the_page_lists_drawings_saved_maps_and_an_example_of_those_that_are_made(saved):
    names = listed_fields(saved)
    assert {"square", "town", "kitchen", "office"} <= set(names)
    assert names[-1] == "generated-17"


def test_a_name_is_what_load_field_takes(saved):
    assert field_named("square", saved) == "square"
    assert field_named("kitchen", saved) == str(saved / "kitchen.svg")
    assert field_named("office", saved) == str(saved / "office.yaml")
    save_map_yaml(
        OccupancyGrid(np.array([[0, 100]], np.int8), 0.5, Pose2()), saved / "kitchen.yaml"
    )
    assert field_named("kitchen", saved) == str(saved / "kitchen.svg"), "the drawing comes first"
    assert field_named("generated-4294967295", saved) == "generated-4294967295"


@pytest.mark.parametrize("name", ["generated-", "generated-01", "generated-4294967296", "moon"])
def test_any_other_name_is_refused_with_those_that_are_valid(name, saved):
    with pytest.raises(CommandError, match=r"square, .*kitchen, generated-0 to generated-4294967"):
        field_named(name, saved)


def test_a_path_of_this_computer_is_no_name(saved):
    path = saved / "office.yaml"
    assert load_field(str(path), MAPS).name == "office"
    for name in (str(path), "office.yaml", str(saved / "kitchen.svg")):
        with pytest.raises(CommandError, match="there is no field"):
            field_named(name, saved)


def test_what_a_feature_makes_is_refused_without_it_by_its_name(saved):
    plug_in(find_features(["lab", "ros"]))
    path = str(saved / "office.yaml")
    assert listed_fields(saved)[-1] == "kitchen"
    assert "office" not in listed_fields(saved)
    with pytest.raises(CommandError, match=r"'generated-17'; .*kitchen; without lab; without ros$"):
        field_named("generated-17", saved)
    for name in ("generated-17", path):
        with pytest.raises(FieldError) as refused:
            load_field(name, MAPS)
        assert str(refused.value).endswith("or an .svg file; without lab; without ros")
        assert name in str(refused.value)
    assert load_field("square", MAPS).name == "square"


def load(path: Path):
    return load_field(str(path), MAPS).name


@pytest.mark.parametrize("name", ["generated-17", "office.yaml"])
def test_another_process_finds_what_features_make(name, saved):
    path = saved / name if name.endswith("yaml") else Path(name)
    assert read_apart(load, path) == path.stem
