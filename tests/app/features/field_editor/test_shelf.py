"""Fields of the user's: kept after they were read once, listed, replaced and deleted."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from places import MAPS

from app.engine.plugging import plug_in, plugged
from app.feature_search import find_features
from app.features.field_editor import shelf as shelf_module
from app.features.field_editor.shelf import FieldFileError, FieldShelf, remarks_in
from robot.fields.field_loading import load_field

SQUARE = (MAPS / "square.svg").read_bytes()
WITH_TEXT = SQUARE.replace(b"</svg>", b'<text x="0" y="0">1 m</text></svg>')
YAML = (
    "image: {image}\nresolution: 0.05\norigin: [-1, -1, 0]\nnegate: 0\noccupied_thresh: 0.65\n"
    "free_thresh: 0.25\n"
)


@pytest.fixture(autouse=True)
def put_back(monkeypatch):
    """What takes part is as it was, afterwards; files are read here, which is quicker."""
    monkeypatch.setattr(shelf_module, "read_apart", lambda read, path: read(path))
    before = plugged().features
    plug_in(find_features())
    yield
    plug_in(before)


@pytest.fixture
def shelf(tmp_path) -> FieldShelf:
    return FieldShelf(tmp_path / "fields")


def picture() -> bytes:
    cells = np.full((40, 40), 254, np.uint8)
    cells[:2], cells[:, :2] = 0, 0
    return cv2.imencode(".pgm", cells)[1].tobytes()


def test_a_drawing_is_kept_listed_replaced_and_deleted(shelf) -> None:
    assert shelf.keep("mine", SQUARE) == ""
    entry = shelf.find("mine")
    assert entry.own
    assert entry.is_drawing
    assert entry.changed > 0
    assert not shelf.find("square").own
    with pytest.raises(FieldFileError, match="there is a field mine already"):
        shelf.keep("mine", SQUARE)
    told = shelf.keep("mine", WITH_TEXT, replace=True)
    assert told == remarks_in(shelf.folder / "mine.svg") != ""
    assert [each.name for each in shelf.listed() if each.own] == ["mine"]
    shelf.delete("mine")
    assert list(shelf.folder.iterdir()) == []


@pytest.mark.parametrize("name", ["", "../mine", "a b", ".mine", "x" * 61, "con", "square"])
def test_names_that_lead_elsewhere_or_are_taken_are_refused(shelf, name: str) -> None:
    with pytest.raises(FieldFileError, match=r"valid are|choose another name"):
        shelf.keep(name, SQUARE, replace=True)
    assert not shelf.folder.exists()


def test_a_file_that_is_no_field_is_not_kept_and_named_by_its_own_name(shelf) -> None:
    shelf.keep("mine", SQUARE)
    for content in (b"", b"\0" * 99, SQUARE[:200], b"<svg/>"):
        with pytest.raises(FieldFileError, match=r"^mine: "):
            shelf.keep("mine", content, replace=True)
    assert (shelf.folder / "mine.svg").read_bytes() == SQUARE
    assert len(list(shelf.folder.iterdir())) == 1


@pytest.mark.parametrize("image", ["office.pgm", "/etc/passwd", "../../secret.png"])
def test_a_map_keeps_the_picture_that_came_with_it(shelf, image: str) -> None:
    text = YAML.format(image=image).encode()
    shelf.keep("office", text + picture(), yaml_bytes=len(text))
    assert sorted(path.name for path in shelf.folder.iterdir()) == ["office.pgm", "office.yaml"]
    entry = shelf.find("office")
    assert not entry.is_drawing
    assert load_field(str(entry.file), MAPS).grid is not None
    shelf.delete("office")
    assert list(shelf.folder.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "behind", "words"),
    [
        (YAML.format(image="a.pgm"), b"PK\3\4", "valid are PGM, PPM, PNG and BMP"),
        ("- 1\n", None, "expected the keys of a map"),
        ("a: [\n", None, "no readable YAML"),
        ("image: a.pgm\n", None, "the key resolution is missing"),
        (YAML.format(image="a.pgm"), b"P5\n40 40\n255\n", "the picture holds too little"),
    ],
)
def test_a_bad_map_is_refused_and_leaves_nothing(shelf, text, behind, words) -> None:
    content = text.encode()
    with pytest.raises(FieldFileError, match=words):
        shelf.keep("office", content + (behind or picture()), yaml_bytes=len(content))
    assert not shelf.folder.exists() or list(shelf.folder.iterdir()) == []


def test_a_full_folder_takes_no_more(shelf, monkeypatch) -> None:
    monkeypatch.setattr(shelf_module, "MOST", 1)
    shelf.keep("first", SQUARE)
    with pytest.raises(FieldFileError, match="delete some fields first"):
        shelf.keep("second", SQUARE)
    shelf.keep("first", WITH_TEXT, replace=True)


def test_fields_of_the_program_cannot_be_deleted(shelf) -> None:
    with pytest.raises(FieldFileError, match="valid are fields of your own"):
        shelf.delete("square")
    assert Path(MAPS / "square.svg").is_file()
