"""ROS maps that cannot be read: each is refused in one clear line, before anything grows."""

import re
import struct
import zlib

import cv2
import numpy as np
import pytest
import yaml

from robot.fields.grid_map import load_map_yaml
from robot.fields.occupancy_grid import MapError

KEYS = {
    "image": "map.pgm",
    "resolution": 0.05,
    "origin": [0.0, 0.0, 0.0],
    "negate": 0,
    "occupied_thresh": 0.65,
    "free_thresh": 0.196,
}
PGM = b"P5 3 2 255\n" + bytes(6)
PNG = cv2.imencode(".png", np.arange(6, dtype=np.uint8).reshape(2, 3))[1].tobytes()
BMP = cv2.imencode(".bmp", np.arange(6, dtype=np.uint8).reshape(2, 3))[1].tobytes()


@pytest.fixture
def load(tmp_path):
    """Reads a map from the bytes of its picture and of its YAML, or from changed keys."""

    def read(picture=PGM, text=None, **keys):
        (tmp_path / "map.pgm").write_bytes(picture)
        content = {key: value for key, value in {**KEYS, **keys}.items() if value != "absent"}
        data = yaml.safe_dump(content).encode() if text is None else text
        (tmp_path / "map.yaml").write_bytes(data)
        return load_map_yaml(tmp_path / "map.yaml")

    return read


def png_of_size(width, height):
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    chunk = b"IHDR" + header
    return (
        b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + chunk + struct.pack(">I", zlib.crc32(chunk))
    )


def refused(load, complaint, *args, **keys):
    with pytest.raises(MapError, match=re.escape(complaint)) as refusal:
        load(*args, **keys)
    message = str(refusal.value)
    assert "\n" not in message
    assert len(message) < 400
    assert "map.yaml: " in message


def test_the_map_that_the_others_are_made_of_is_fine(load):
    assert load().data.shape == (2, 3)
    assert load(PNG).data.shape == load(BMP).data.shape == (2, 3)


@pytest.mark.parametrize("key", list(KEYS))
def test_a_missing_key_is_named(load, key):
    refused(load, key, **{key: "absent"})


@pytest.mark.parametrize(
    ("keys", "complaint"),
    [
        ({"resolution": float("nan")}, "resolution is '.nan'"),
        ({"resolution": float("inf")}, "resolution is '.inf'"),
        ({"resolution": 0}, "resolution is 0.0 m; valid is 0.0001 to 100"),
        ({"resolution": -0.05}, "resolution is -0.05 m"),
        ({"resolution": 1e9}, "resolution is 1000000000.0 m"),
        (
            {"resolution": 50},
            "resolution is 50.0 m a pixel; valid is 0.0001 to 1: was it given in mm or cm?",
        ),
        (
            {"origin": [0, 0, 90]},
            "90 rad; valid is up to 2 pi either way: was it given in degrees? those are 1.5708",
        ),
        ({"origin": [0, 0, -180]}, "degrees? those are -3.1416"),
        ({"occupied_thresh": 0.196, "free_thresh": 0.65}, "wrong way round"),
        ({"resolution": "big"}, "resolution is 'big'; valid is a finite number"),
        ({"resolution": [1]}, "resolution is ['1']"),
        ({"origin": [0, 0]}, "valid is a list of 3 numbers"),
        ({"origin": "here"}, "origin is 'here'"),
        ({"origin": [0, 0, float("nan")]}, "origin is '.nan'"),
        ({"origin": [1e9, 0, 0]}, "valid is within 1e+06 m"),
        ({"occupied_thresh": 65}, "occupied_thresh is 65.0; valid is 0 to 1"),
        ({"free_thresh": -0.1}, "free_thresh is -0.1"),
        ({"negate": "perhaps"}, "negate is 'perhaps'; valid are 0, 1"),
        ({"mode": "quaternary"}, "valid are trinary, scale, raw"),
        ({"image": ""}, "image is ''"),
        ({"image": "a\0b"}, "image is 'a\\x00b'"),
        ({"image": "nothing.pgm"}, "nothing.pgm: there is no such file"),
        ({"image": "."}, "there is no such file"),
        ({"image": "a" * 5000}, "the file cannot be read"),
        ({"resolution": "9" * 5000}, "resolution is"),
    ],
)
def test_an_absurd_value_is_refused(load, keys, complaint):
    refused(load, complaint, **keys)


@pytest.mark.parametrize("folder", ["/home/x/maps/", "C:\\maps\\", "../elsewhere/", ""])
def test_a_copied_map_has_its_image_beside_it(folder, load, caplog):
    assert load(image=f"{folder}map.pgm").data.shape == (2, 3)
    warned = f"there is no {folder}map.pgm; map.pgm beside it is read" in caplog.text
    assert warned == bool(folder)
    refused(load, "other.pgm: there is no such file", image=f"{folder}other.pgm")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (b"", "expected the keys"),
        (b"- 1\n- 2", "expected the keys"),
        (b"image: [", "no readable YAML"),
        (b"\xff\xfe\x00", "no readable YAML"),
        (b"[" * 5000, "no readable YAML"),
        (b"&a [*a]: 1", "no readable YAML"),
        (b"image: " + b"x" * 70_000, "valid are up to 65536"),
    ],
)
def test_a_broken_yaml_is_refused(load, text, complaint):
    refused(load, complaint, text=text)


@pytest.mark.parametrize(
    ("picture", "complaint"),
    [
        (b"", "no picture of a known kind; valid are PGM, PPM, PNG and BMP"),
        (b"GIF89a", "no picture of a known kind"),
        (b"P5", "no picture of a known kind"),
        (b"P5 x", "PGM header is damaged"),
        (b"P5 3 2 255\n12345", "holds too little"),
        (b"P5 3 2 0\n123456", "brightest value"),
        (b"P5 3 2 70000\n123456", "brightest value"),
        (b"P5 0 2 255\n", "the picture is 0 x 2 px"),
        (b"P5 40000 1 255\n", "the picture is 40000 x 1 px"),
        (b"P5 31000 31000 255\n", "the picture is 31000 x 31000 px"),
        (b"P6 3 2 255\n" + bytes(17), "holds too little for 3 x 2 px"),
        (b"P6 31000 31000 255\n", "the picture is 31000 x 31000 px"),
        (b"P4 3 2\n1", "no picture of a known kind"),
        (b"P2 2 1 255\n1 x", "PGM digits are damaged"),
        (b"P2 2 1 255\n1", "holds too little"),
        (PNG[:20], "ends within its header"),
        (PNG[:50], "the picture is damaged"),
        (PNG[:45] + b"!" + PNG[46:], "the picture is damaged"),
        (png_of_size(31_000, 31_000), "the picture is 31000 x 31000 px; valid are 1 to 32000"),
        (png_of_size(0, 5), "the picture is 0 x 5 px"),
        (BMP[:16], "ends within its header"),
        (BMP[:-3], "the picture is damaged"),
        (BMP[:18] + struct.pack("<ii", 30_000, -30_000) + BMP[26:], "30000 x 30000 px"),
    ],
)
def test_a_damaged_or_huge_picture_is_refused(load, picture, complaint):
    refused(load, complaint, picture)


def test_a_picture_of_a_gigabyte_is_refused_unread(tmp_path, load):
    with (tmp_path / "huge.pgm").open("wb") as file:
        file.write(b"P5 30000 2000 255\n")
        file.truncate(1 << 30)
    refused(load, "1073741824 bytes; valid are up to", image="huge.pgm")


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("map.pgm", "map.pgm: it is a picture; valid is the map's YAML, which names it"),
        ("map.PNG", "it is a picture"),
        ("office.posegraph", "slam_toolbox keeps of a map; .* map_saver_cli saves one"),
        ("office.pbstream", "what Cartographer keeps of a map"),
        (".", "it is a folder; valid is a map's YAML, of which it has map.yaml$"),
    ],
)
def test_what_is_given_for_a_maps_yaml_is_named(tmp_path, name, complaint):
    if name != ".":
        (tmp_path / name).write_bytes(PGM)
    (tmp_path / "map.yaml").write_text("image: map.pgm")
    with pytest.raises(MapError, match=complaint):
        load_map_yaml(tmp_path / name)


def test_an_absent_map_is_refused(tmp_path):
    with pytest.raises(MapError, match="there is no such file"):
        load_map_yaml(tmp_path / "absent.yaml")
