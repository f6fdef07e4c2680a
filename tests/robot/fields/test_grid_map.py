"""What pixels mean, mode by mode, by hand-worked examples of nav2's rules; and writing them."""

import math

import cv2
import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from robot.fields.grid_map import Meaning, load_map_yaml, save_map_yaml
from robot.fields.occupancy_grid import MapError, OccupancyGrid
from robot.geometry import Pose2

KEYS = {
    "image": "map.png",
    "resolution": 0.05,
    "origin": [1.0, 2.0, 0.5],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}


@pytest.fixture
def saved(tmp_path):
    """Writes a picture and its YAML, and reads them as a map."""

    def load(pixels, **keys):
        content = {**KEYS, **keys}
        cv2.imwrite(str(tmp_path / content["image"]), np.asarray(pixels))
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
        return load_map_yaml(tmp_path / "map.yaml")

    return load


def row(*greys):
    return np.array([greys], dtype=np.uint8)


def test_trinary_tells_occupied_free_and_unknown_apart(saved):
    # Darkness 1 - grey / 255: 0.651 and 0.647 about 0.65, 0.196078 and 0.192 about 0.196.
    grid = saved(row(0, 89, 90, 128, 205, 206, 255))
    assert grid.data.tolist() == [[100, 100, -1, -1, -1, 0, 0]]


def test_thresholds_themselves_are_unknown(saved):
    grid = saved(row(102, 204), occupied_thresh=0.6, free_thresh=0.19999999999999996)
    assert grid.data.tolist() == [[-1, -1]]


def test_negate_makes_white_occupied(saved):
    assert saved(row(0, 128, 255), negate=1).data.tolist() == [[0, -1, 100]]


def test_scale_spreads_what_is_between_the_thresholds(saved):
    grid = saved(row(0, 89, 90, 128, 205, 206), mode="scale")
    # (1 - 90/255 - 0.196) / (0.65 - 0.196) = 0.9935; 128: 0.6654; 205: 0.0002
    assert grid.data.tolist() == [[100, 100, 99, 67, 0, 0]]


def test_raw_takes_the_value_itself_and_does_not_look_at_negate(saved):
    for negate in (0, 1):
        grid = saved(row(0, 1, 99, 100, 101, 255), mode="raw", negate=negate)
        assert grid.data.tolist() == [[0, 1, 99, 100, -1, -1]]


def test_row_0_of_the_grid_is_the_bottom_of_the_picture(saved):
    grid = saved(np.array([[0, 255], [255, 255], [128, 255]], np.uint8))
    assert grid.data.tolist() == [[-1, 0], [0, 0], [100, 0]]


def test_colours_count_by_their_mean(saved):
    bgr = np.array([[[0, 0, 255], [255, 255, 0], [255, 255, 255]]], np.uint8)
    # Darkness 2/3 is occupied, 1/3 is unknown.
    assert saved(bgr).data.tolist() == [[100, -1, 0]]


def test_alpha_is_one_more_channel_in_trinary(saved):
    bgra = np.array([[[0, 0, 0, 255], [0, 0, 0, 0], [255, 255, 255, 0]]], np.uint8)
    # Darkness 3/4, 1 and 1/4.
    assert saved(bgra).data.tolist() == [[100, 100, -1]]


def test_what_is_not_opaque_is_unknown_in_scale(saved):
    bgra = np.array([[[0, 0, 0, 255], [0, 0, 0, 254], [255, 255, 255, 255]]], np.uint8)
    assert saved(bgra, mode="scale").data.tolist() == [[100, -1, 0]]


def test_alpha_is_not_looked_at_in_raw(saved):
    bgra = np.array([[[50, 50, 50, 0]]], np.uint8)
    assert saved(bgra, mode="raw").data.tolist() == [[50]]


def test_pictures_of_16_bits_keep_their_precision(saved):
    grey = np.array([[0, 257 * 89, 257 * 90, 65535]], np.uint16)
    assert saved(grey).data.tolist() == [[100, 100, -1, 0]]


@pytest.mark.parametrize("image", ["map.pgm", "map.png", "map.bmp"])
def test_kinds_of_picture_with_the_same_content_give_the_same_cells(saved, image):
    greys = np.arange(256, dtype=np.uint8).reshape(16, 16)
    expected = Meaning(free_thresh=0.196).cells(greys[::-1].ravel() / 255).reshape(16, 16)
    assert (saved(greys, image=image).data == expected).all()


@pytest.mark.parametrize(
    "text", ["P2\n# made by hand\n3 1\n100\n0 50\n100\n", "P2 3 1 100 0 50 100"]
)
def test_a_pgm_in_digits_is_read_by_its_own_brightest_value(tmp_path, text):
    (tmp_path / "map.pgm").write_text(text)
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({**KEYS, "image": "map.pgm"}))
    assert load_map_yaml(tmp_path / "map.yaml").data.tolist() == [[100, -1, 0]]


@pytest.mark.parametrize(
    ("header", "values"),
    [(b"P5 3 1 100\n", bytes([0, 50, 100])), (b"P5 3 1 1000\n", b"\0\0\1\xf4\3\xe8")],
)
def test_a_binary_pgm_is_read_by_its_own_brightest_value(tmp_path, header, values):
    (tmp_path / "map.pgm").write_bytes(header + values)
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({**KEYS, "image": "map.pgm"}))
    assert load_map_yaml(tmp_path / "map.yaml").data.tolist() == [[100, -1, 0]]


@pytest.mark.parametrize(
    "picture",
    [
        b"P6\n# by a student's tool\n4 1\n255\n"
        + bytes([0, 0, 0, 255, 255, 255, 205, 205, 205, 0, 255, 60]),
        b"P6 4 1 1000\n"
        + np.array([0] * 3 + [1000] * 3 + [800] * 3 + [0, 1000, 235], ">u2").tobytes(),
        b"P3 4 1 100 0 0 0 100 100 100 80 80 80 0 100 24",
    ],
    ids=["8 bits", "16 bits", "digits"],
)
def test_a_colour_map_by_the_name_of_a_pgm_is_averaged_as_map_server_does(tmp_path, picture):
    """Darkness 0.2 is between the thresholds, and so is that of a colour with the mean 105."""
    (tmp_path / "map.pgm").write_bytes(picture)
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({**KEYS, "image": "map.pgm"}))
    assert load_map_yaml(tmp_path / "map.yaml").data.tolist() == [[100, 0, -1, -1]]


def test_the_fourth_byte_of_a_bmp_is_not_taken_for_alpha(tmp_path):
    header = b"BM" + (62).to_bytes(4, "little") + bytes(4) + (54).to_bytes(4, "little")
    header += b"".join(n.to_bytes(4, "little") for n in (40, 2, 1, 1 | 32 << 16, 0, 8, 0, 0, 0, 0))
    (tmp_path / "map.bmp").write_bytes(header + bytes([255, 255, 255, 0, 0, 0, 0, 0]))
    (tmp_path / "map.yaml").write_text(yaml.safe_dump({**KEYS, "image": "map.bmp"}))
    assert load_map_yaml(tmp_path / "map.yaml").data.tolist() == [[0, 100]]


def test_numbers_and_flags_are_read_as_yaml_cpp_reads_them(tmp_path):
    cv2.imwrite(str(tmp_path / "1e3.png"), row(0))
    (tmp_path / "map.yaml").write_text(
        "image: 1e3.png\nresolution: 5e-2\norigin: [010, -1., .5]\nnegate: Yes\nmode: TRINARY\n"
        "occupied_thresh: '0.65'\nfree_thresh: 196e-3\n"
    )
    grid = load_map_yaml(tmp_path / "map.yaml")
    assert (grid.resolution, grid.origin) == (0.05, Pose2(10.0, -1.0, 0.5))
    assert grid.data.tolist() == [[0]]


def test_a_picture_may_lie_elsewhere(tmp_path):
    (tmp_path / "pictures").mkdir()
    cv2.imwrite(str(tmp_path / "pictures" / "a.png"), row(0))
    for image in ("pictures/a.png", str(tmp_path / "pictures" / "a.png")):
        (tmp_path / "map.yaml").write_text(yaml.safe_dump({**KEYS, "image": image}))
        assert load_map_yaml(tmp_path / "map.yaml").data.tolist() == [[100]]


# --- writing -------------------------------------------------------------------------------------

values = st.one_of(st.just(-1), st.integers(0, 100))
grids = st.builds(
    OccupancyGrid,
    arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=6), elements=values),
    st.floats(0.001, 1),
    st.builds(Pose2, st.floats(-99, 99), st.floats(-99, 99), st.floats(-3, 3)),
)
tmp_path_once = settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@tmp_path_once
@given(grids, st.sampled_from(["pgm", "png"]))
def test_raw_keeps_every_value_and_place(tmp_path, grid, picture):
    save_map_yaml(grid, tmp_path / "out.yaml", Meaning("raw"), picture)
    again = load_map_yaml(tmp_path / "out.yaml")
    assert (again.data == grid.data).all()
    assert (again.resolution, again.origin) == (grid.resolution, grid.origin)


@tmp_path_once
@given(grids)
def test_scale_keeps_every_value_between_thresholds_of_0_and_1(tmp_path, grid):
    meaning = Meaning("scale", occupied_thresh=1.0, free_thresh=0.0)
    save_map_yaml(grid, tmp_path / "out.yaml", meaning)
    assert (load_map_yaml(tmp_path / "out.yaml").data == grid.data).all()


@tmp_path_once
@given(grids, st.sampled_from(["pgm", "png"]), st.sampled_from([0.1, 0.196, 0.25, 0.5]))
def test_trinary_keeps_what_is_clear_and_forgets_the_rest(tmp_path, grid, picture, free):
    save_map_yaml(grid, tmp_path / "out.yaml", Meaning(free_thresh=free), picture)
    again = load_map_yaml(tmp_path / "out.yaml").data
    percent = round(free * 100)
    assert (again[grid.data >= 65] == 100).all()
    assert (again[(grid.data >= 0) & (grid.data <= percent)] == 0).all()
    assert (again[(grid.data == -1) | ((grid.data > percent) & (grid.data < 65))] == -1).all()


def test_the_written_files_are_map_servers(tmp_path):
    grid = OccupancyGrid(np.array([[0, 100, -1]], np.int8), 0.05, Pose2(1, 2, 0.5))
    save_map_yaml(grid, tmp_path / "out.yaml")
    assert cv2.imread(str(tmp_path / "out.pgm"), -1).tolist() == [[254, 0, 205]]
    assert yaml.safe_load((tmp_path / "out.yaml").read_text()) == {
        "image": "out.pgm", "mode": "trinary", "resolution": 0.05, "origin": [1.0, 2.0, 0.5],
        "negate": 0, "occupied_thresh": 0.65, "free_thresh": 0.196,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("meaning", "picture"),
    [(Meaning("scale"), "pgm"), (Meaning(), "gif"), (Meaning(negate=True), "pgm"),
     (Meaning(free_thresh=0.7), "pgm")],
)  # fmt: skip
def test_what_map_server_would_not_read_back_is_not_written(tmp_path, meaning, picture):
    grid = OccupancyGrid(np.zeros((1, 1), np.int8), 0.05, Pose2())
    with pytest.raises(MapError, match="are"):
        save_map_yaml(grid, tmp_path / "out.yaml", meaning, picture)
    assert not list(tmp_path.iterdir())


# --- grids ---------------------------------------------------------------------------------------


def test_values_at_points_honour_the_origins_heading():
    data = np.arange(6, dtype=np.int8).reshape(2, 3)
    grid = OccupancyGrid(data, 0.5, Pose2(10, 20, math.pi / 2))
    # Columns run along +y of the map and rows along -x.
    points = np.array([[9.9, 20.1], [9.9, 21.4], [9.1, 20.1], [10.1, 20.1], [9.9, 21.6]])
    assert grid.values_at(points).tolist() == [0, 2, 3, -1, -1]


@pytest.mark.parametrize(
    ("data", "resolution", "origin", "complaint"),
    [
        (np.zeros((0, 5), np.int8), 0.05, Pose2(), "valid are 1 to"),
        (np.zeros(5, np.int8), 0.05, Pose2(), "valid are 1 to"),
        (np.full((1, 1), 101, np.int8), 0.05, Pose2(), "valid are -1"),
        (np.full((1, 1), -2, np.int8), 0.05, Pose2(), "valid are -1"),
        (np.zeros((1, 1), np.int16), 0.05, Pose2(), "valid are -1"),
        (np.zeros((1, 1), np.int8), 0.0, Pose2(), "resolution is 0"),
        (np.zeros((1, 1), np.int8), float("nan"), Pose2(), "resolution is nan"),
        (np.zeros((1, 1), np.int8), 0.05, Pose2(float("inf"), 0, 0), "origin"),
    ],
)
def test_a_grid_that_cannot_be_is_refused(data, resolution, origin, complaint):
    with pytest.raises(MapError, match=complaint):
        OccupancyGrid(data, resolution, origin)
