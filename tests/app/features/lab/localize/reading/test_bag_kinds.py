"""What a bag is, its content says: other names are taken, other files named as what they are."""

import gzip
import shutil

import pytest
from laser_office import drive, write_bag, write_map

from app.command_line import main
from app.features.lab.localize.reading.bag import Bag
from app.features.lab.localize.reading.sources import BagError
from app.features.recordings.files.file_kinds import BAGS
from benchmarks.lasers.laser_bags import KINDS

SEEN = 5


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    """The file of each kind of bag."""
    folder = tmp_path_factory.mktemp("bags")
    files = {}
    for kind in KINDS:
        bag = write_bag(folder / f"{kind}.bag", kind, seen=drive()[:SEEN])
        files[kind] = next(bag.glob("*.[md]*[p3]")) if bag.is_dir() else bag
    return files


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["drive", "drive.mcap", "drive.db3", "drive.bag", "drive.mcap.1"])
def test_a_bag_by_any_name_is_read(tmp_path, bags, kind, name):
    shutil.copy(bags[kind], tmp_path / name)
    with Bag(tmp_path / name) as bag:
        assert len(list(bag.messages(["/scan"]))) == SEEN
        assert bag.damages == []


OTHERS = {
    "zip": (b"PK\x03\x04rest", r"is a zip archive \(unzip unpacks it\)"),
    "tar.gz": (gzip.compress(b"x"), r"compressed as a whole by gzip \(gunzip or tar unpacks it\)"),
    "tar.bz2": (b"BZh91AY", "compressed as a whole by bzip2"),
    "pointer": (b"version https://git-lfs.github.com/spec/v1\noid", "git lfs pull gets it"),
    "page": (b"<!DOCTYPE html><html>", "is a web page, maybe of where the file can be fetched"),
}


@pytest.mark.parametrize("ending", ["bag", "db3", "mcap", ""])
@pytest.mark.parametrize("kind", OTHERS)
def test_another_file_is_named_and_no_cure_that_does_nothing_is_given(tmp_path, kind, ending):
    content, words = OTHERS[kind]
    path = tmp_path / f"drive.{ending or kind}"
    path.write_bytes(content)
    with pytest.raises(BagError if ending != "mcap" else ValueError, match=words) as told:
        Bag(path)
    assert "reindex" not in str(told.value)


@pytest.mark.parametrize("ending", ["bag", "db3"])
@pytest.mark.parametrize(("content", "words"), [(b"", "is empty"), (b"some words", "is no bag")])
def test_no_bag_at_all(tmp_path, ending, content, words):
    path = tmp_path / f"drive.{ending}"
    path.write_bytes(content)
    with pytest.raises(BagError, match=f"{words}.*; valid is a bag") as told:
        Bag(path)
    assert "reindex" not in str(told.value)


def test_a_laser_has_no_use_for_a_drawing(tmp_path, bags, capsys):
    write_map(tmp_path)
    drawing = tmp_path / "town.svg"
    drawing.write_text("<svg/>")
    assert main(["localize", str(bags["mcap"]), "--map", str(drawing)]) == 2
    assert "town.svg is a drawing of tape; valid for a laser is a map's YAML" in (
        capsys.readouterr().err
    )


def test_the_first_bytes_of_each_kind_of_bag_are_known(bags):
    begun = {bags[kind].read_bytes()[:20] for kind in KINDS}
    assert all(any(begin.startswith(start) for begin in begun) for start in BAGS)
