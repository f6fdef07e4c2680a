"""Lists of students, as people and spreadsheets write them."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.features.classroom.roster import MOST, RosterError, Student, login_of, read_roster


def listed(tmp_path, text: str | bytes):
    path = tmp_path / "students.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_roster(path)


BOTH = (Student("Lovelace, Ada", "lovelace-ada"), Student("Jürgen Groß", "juergen-gross"))


@pytest.mark.parametrize(
    "text",
    [
        "Lovelace, Ada\nJürgen Groß\n",
        '\ufeffname,group\r\n"Lovelace, Ada",7a\r\nJürgen Groß,7b\r\n',
        "Group;Name\n7a;Lovelace, Ada\n\n7b; Jürgen  Groß \n",
        "name\tgroup\nLovelace, Ada\t1\nJürgen Groß\t2",
        'Name\n"Lovelace, Ada"\nJürgen Groß'.encode("cp1252"),
    ],
    ids=["one a line", "commas, with a mark", "semicolons", "tabs", "Windows"],
)
def test_names_are_read_as_people_and_spreadsheets_write_them(text, tmp_path):
    assert listed(tmp_path, text) == BOTH


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("Ada\nBo\nada\n", "line 3: ada and Ada (line 1) have the same name in addresses, ada"),
        ("Müller\nMueller\n", "line 2: Mueller and Müller (line 1) have the same name"),
        ("", "has no student; valid is a name a line"),
        ("name,group\n", "has no student"),
        ("Ada\n???\n", "line 2: '???' is no name"),
        ("x" * 81, "is no name; valid are up to 80 characters"),
        ("Teacher\n", "line 1: Teacher is the teacher's own name"),
        ("name,group\nLovelace, Ada,7a\n", 'stands in quotes, as "Lovelace, Ada"'),
        ('name,group\n"Ada,7a\n', "line 2: "),
        ("name,group\n,7a\n", "line 2 has 2 cells and no name"),
        ("Vorname;Nachname\nAda;Lovelace\n", "columns are vorname, nachname; valid is one of"),
        (b"PK\0\0", "is no text; valid is CSV"),
        ("\n".join(f"s{n}" for n in range(MOST + 1)), f"has {MOST + 1} students"),
    ],
)
def test_a_wrong_list_is_refused_with_the_line_and_what_is_valid(text, told, tmp_path):
    with pytest.raises(RosterError, match=re.escape(told)):
        listed(tmp_path, text)


def test_a_list_that_is_not_there_is_named(tmp_path):
    with pytest.raises(RosterError, match=r"absent\.csv cannot be read: No such file"):
        read_roster(tmp_path / "absent.csv")


@given(st.text(max_size=30))
def test_what_the_hub_calls_a_student_is_safe_in_addresses_and_folders(name):
    assert re.fullmatch(r"([a-z0-9]+(-[a-z0-9]+)*)?", login_of(name))
    assert login_of(login_of(name)) == login_of(name)
