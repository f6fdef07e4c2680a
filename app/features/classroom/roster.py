"""The list of students: names as people write them, and the names that the hub knows them by."""

from __future__ import annotations

import csv
import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from robot.errors import BrickPoseError

NAME = "name"
MOST = 200
LONGEST = 80
GERMAN = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "ø": "o", "æ": "ae", "ł": "l"})
TEACHER = "teacher"
"""The hub's name of who teaches; no student has it."""
DELIMITERS = ",;\t"


class RosterError(BrickPoseError, ValueError):
    """A list of students cannot be used; the message says which line, and what is valid."""


@dataclass(frozen=True)
class Student:
    """One student."""

    name: str
    """As it is written in the list."""
    login: str
    """What the hub, folders and addresses call the student: small letters, digits and ``-``."""


def read_roster(path: Path) -> tuple[Student, ...]:
    """Return the students of a file, in its order.

    With a first line that has a column ``name``, it is a table, with commas, semicolons or tabs as
    spreadsheets write it. Else each line is one name, with whatever commas are in it.

    Raises:
        RosterError: it cannot be read, has no name, or a name twice; or it is a table without
            that column. With commas that cannot be told from "Lovelace, Ada".
    """
    named: dict[str, tuple[str, int]] = {}
    for line, name in _names(_text(path), path):
        login = login_of(name)
        if not login or len(name) > LONGEST:
            raise RosterError(
                f"{path}, line {line}: {name[:LONGEST]!r} is no name; valid are up to {LONGEST} "
                "characters with a letter or a digit of the Latin alphabet among them"
            )
        if login == TEACHER:
            raise RosterError(f"{path}, line {line}: {name} is the teacher's own name; add another")
        if login in named:
            other, before = named[login]
            raise RosterError(
                f"{path}, line {line}: {name} and {other} (line {before}) have the same name in "
                f"addresses, {login}; add a letter to one of them"
            )
        named[login] = name, line
    if not named:
        raise RosterError(f"{path} has no student; valid is a name a line, or a column 'name'")
    if len(named) > MOST:
        raise RosterError(f"{path} has {len(named)} students; valid are up to {MOST}")
    return tuple(Student(name, login) for login, (name, _) in named.items())


def login_of(name: str) -> str:
    """Return the name as addresses and folders can have it.

    >>> login_of("Jürgen Groß-Öl")
    'juergen-gross-oel'
    """
    plain = unicodedata.normalize("NFC", name).lower().translate(GERMAN)
    plain = unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode()
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-")


def _text(path: Path) -> str:
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RosterError(f"{path} cannot be read: {error.strerror}") from error
    if b"\0" in content:
        raise RosterError(f"{path} is no text; valid is CSV, as a spreadsheet saves it")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:  # as spreadsheets on Windows save it
        return content.decode("cp1252", "replace")


def _names(text: str, path: Path) -> Iterator[tuple[int, str]]:
    """Yield the number of each line that has a name, and the name."""
    lines = text.splitlines()
    delimiter = max(DELIMITERS, key=(lines or [""])[0].count)
    header = [cell.strip().strip('"').lower() for cell in (lines or [""])[0].split(delimiter)]
    if NAME not in header:
        if delimiter != "," and len(header) > 1:
            raise RosterError(
                f"{path} is a table without a column {NAME!r}; its columns are "
                f"{', '.join(header)}; valid is one of that name, or a name a line"
            )
        for number, line in enumerate(lines, 1):
            name = " ".join(line.strip().strip('"').split())
            if name:
                yield number, name
        return
    place = header.index(NAME)
    rows = csv.reader(lines, delimiter=delimiter, strict=True)
    try:
        for row in rows:
            if rows.line_num == 1 or not any(cell.strip() for cell in row):
                continue
            name = " ".join(row[place].split()) if len(row) > place else ""
            if not name or len(row) > len(header):
                raise RosterError(
                    f"{path}, line {rows.line_num} has {len(row)} cells and "
                    f"{'no name' if not name else 'the first line ' + str(len(header))}; a name "
                    f'with {delimiter!r} in it stands in quotes, as "Lovelace, Ada"'
                )
            yield rows.line_num, name
    except csv.Error as error:
        raise RosterError(f"{path}, line {rows.line_num}: {error}") from error
