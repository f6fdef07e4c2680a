"""What lasts of a class: keys, and the page with the links."""

from __future__ import annotations

import re
import stat

import pytest

from app.features.classroom.class_folder import ClassFolder, ClassFolderError
from app.features.classroom.links_page import write_links
from app.features.classroom.roster import Student

ADA, BO = Student("Ada <b>Lovelace</b>", "ada"), Student("Bo", "bo")


@pytest.fixture
def folder(tmp_path):
    made = ClassFolder(tmp_path / "students.class")
    made.make()
    return made


def test_links_last_and_who_is_not_there_today_keeps_theirs(folder):
    first = folder.keys([ADA, BO])
    assert set(first) == {"teacher", "ada", "bo"}
    assert len(set(first.values())) == 3
    assert all(re.fullmatch(r"[\w-]{16}", key) for key in first.values())
    assert set(folder.keys([BO])) == {"teacher", "bo"}
    assert folder.keys([ADA, BO]) == first


def test_only_the_teacher_reads_keys_and_links(folder):
    keys = folder.keys([ADA])
    write_links(folder.links, "http://school.example:8000", [ADA], keys)
    for path in (folder.path / "keys.json", folder.links):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_the_page_has_each_name_link_and_code(folder):
    keys = folder.keys([ADA, BO])
    write_links(folder.links, "http://school.example:8000", [ADA, BO], keys)
    text = folder.links.read_text(encoding="utf-8")
    for login in ("ada", "bo", "teacher"):
        assert f'href="http://school.example:8000/hub/enter/{keys[login]}"' in text
    assert text.count("<svg") == 3
    assert "Ada &lt;b&gt;Lovelace&lt;/b&gt;" in text
    assert "http" not in re.sub(r"http://(school\.example:8000|www\.w3\.org)", "", text)


def test_damaged_keys_are_named_with_a_cure(folder):
    (folder.path / "keys.json").write_text("{")
    with pytest.raises(ClassFolderError, match=r"keys\.json cannot be read.*remove it"):
        folder.keys([ADA])
