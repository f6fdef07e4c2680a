"""Files that other files name are found, however their names' accents are written."""

import unicodedata

import cv2
import numpy as np
import pytest
from laser_office import office, write_bag

from app.features.lab.localize.pictures.sequence import read_sequence
from app.features.lab.localize.reading.bag import Bag
from robot.fields.grid_map import load_map_yaml, save_map_yaml
from robot.file_names import as_written

NAME = "Büro façade"
APART, TOGETHER = (unicodedata.normalize(form, NAME) for form in ("NFD", "NFC"))
WAYS = pytest.mark.parametrize(("lies", "named"), [(APART, TOGETHER), (TOGETHER, APART)])


@WAYS
@pytest.mark.parametrize("folder", ["{0}/{0}", "../nobody/{0}", "C:\\maps\\{0}"])
def test_a_map_finds_its_image(tmp_path, lies, named, folder):
    path, place = tmp_path / "map.yaml", tmp_path
    save_map_yaml(office(), path)
    if folder == "{0}/{0}":
        place = tmp_path / lies
        place.mkdir()
    (tmp_path / "map.pgm").rename(place / f"{lies}.pgm")
    text = path.read_text(encoding="utf-8").splitlines()
    text[0] = f"image: {folder.format(named)}.pgm"
    path.write_text("\n".join(text), encoding="utf-8")
    assert (load_map_yaml(path).data == office().data).all()


@WAYS
def test_a_list_of_stamps_finds_its_pictures(tmp_path, lies, named):
    for number in range(2):
        cv2.imwrite(str(tmp_path / f"{lies} {number}.png"), np.zeros((4, 4), np.uint8))
    stamps = tmp_path / "stamps.csv"
    stamps.write_text(f"stamp,file\n1.5,rgb/{named} 0.png\n2.5,{named} 1.png\n", encoding="utf-8")
    pictures = read_sequence(tmp_path, stamps)
    assert [picture.path.name for picture in pictures] == [f"{lies} 0.png", f"{lies} 1.png"]


@WAYS
def test_a_bags_metadata_finds_its_files(tmp_path, lies, named):
    folder = tmp_path / "bag"
    write_bag(folder, "sqlite3")
    (held,) = folder.glob("*.db3")
    held.rename(folder / f"{lies}.db3")
    metadata = folder / "metadata.yaml"
    text = metadata.read_text(encoding="utf-8").replace(held.name, f"{named}.db3")
    metadata.write_text(text, encoding="utf-8")
    with Bag(folder) as bag:
        assert bag.damages == []


def test_of_two_files_that_are_alike_none_is_taken(tmp_path):
    for name in (APART, TOGETHER):
        (tmp_path / name).touch()
    assert as_written(tmp_path / TOGETHER) == tmp_path / TOGETHER
    mixed = "Bu\u0308ro fa\u00e7ade"
    assert as_written(tmp_path / mixed) == tmp_path / mixed
    assert as_written(tmp_path / "nobody" / NAME) == tmp_path / "nobody" / NAME
    assert as_written(tmp_path / "a\0b") == tmp_path / "a\0b"
