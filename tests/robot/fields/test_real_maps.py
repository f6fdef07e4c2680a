"""Real ROS maps, recorded by others; they are not part of the repository."""

import cv2
import numpy as np
import pytest
import yaml
from places import SHARED

from robot.fields.grid_map import load_map_yaml
from robot.fields.occupancy_grid import MapError
from robot.geometry import Pose2

REAL = SHARED / "maps"

pytestmark = [
    pytest.mark.data,
    pytest.mark.skipif(not REAL.is_dir(), reason="needs the recorded maps"),
]


@pytest.mark.parametrize(
    ("name", "shape", "free_thresh"),
    [
        ("tb3/map.pgm", (384, 384), 0.196),
        ("f1tenth/berlin.png", (600, 600), 0.196),
        ("f1tenth/levine.png", (2048, 2048), 0.196),
        ("nav2/depot.pgm", (307, 604), 0.25),
        ("nav2/keepout_mask.pgm", (384, 384), 0.196),
    ],
)
def test_every_map_loads(name, shape, free_thresh):
    grid = load_map_yaml((REAL / name).with_suffix(".yaml"))
    pixels = cv2.imread(str(REAL / name), cv2.IMREAD_UNCHANGED)[::-1].astype(float)
    dark = 1 - (pixels if pixels.ndim == 2 else pixels.mean(axis=2)) / 255
    assert grid.data.shape == shape
    assert (grid.data == np.select([dark > 0.65, dark < free_thresh], [100, 0], -1)).all()
    assert grid.occupied.any()
    assert grid.free.any()


@pytest.mark.parametrize("kind", ["png", "pgm", "bmp"])
def test_the_same_content_gives_the_same_cells(tmp_path, kind):
    content = yaml.safe_load((REAL / "nav2/testmap.yaml").read_text())
    content["image"] = str(REAL / f"nav2/testmap.{kind}")
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(content))
    grid = load_map_yaml(tmp_path / "map.yaml")
    ros1 = load_map_yaml(REAL / "map_server_ros1/testmap.yaml")
    assert (grid.data == ros1.data).all()
    assert grid.origin == ros1.origin == Pose2(2.0, 3.0, 1.0)
    assert {*np.unique(grid.data)} == {0, 100}


@pytest.mark.parametrize("mode", ["trinary", "scale", "raw"])
def test_all_256_greys_have_the_meaning_of_their_mode(tmp_path, mode):
    image = REAL / "map_server_ros1/spectrum.png"
    keys = {"image": str(image), "mode": mode, "resolution": 0.05, "origin": [0, 0, 0]}
    keys |= {"negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196}
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(keys))
    greys = cv2.imread(str(image), cv2.IMREAD_UNCHANGED)[::-1].astype(float)
    assert len(np.unique(greys)) == 256
    dark = 1 - greys / 255
    between = np.rint((dark - 0.196) / (0.65 - 0.196) * 100)
    expected = {
        "trinary": np.select([dark > 0.65, dark < 0.196], [100, 0], -1),
        "scale": np.select([dark > 0.65, dark < 0.196], [100, 0], between),
        "raw": np.where(greys <= 100, greys, -1),
    }[mode]
    assert (load_map_yaml(tmp_path / "map.yaml").data == expected).all()


def test_a_map_that_names_an_absent_picture_is_a_clear_error():
    with pytest.raises(MapError, match=r"empty_room\.yaml: the image .*empty\.pgm: there is no"):
        load_map_yaml(REAL / "nav2/empty_room.yaml")


def test_grey_216_is_free_by_the_thresholds_of_its_map():
    grid = load_map_yaml(REAL / "f1tenth/levine.yaml")
    image = cv2.imread(str(REAL / "f1tenth/levine.png"), cv2.IMREAD_UNCHANGED)[::-1]
    assert (image == 216).mean() > 0.5
    assert (grid.data[image == 216] == 0).all()
