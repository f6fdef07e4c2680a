"""``brickpose check`` of a class: many files, the same whoever grades them in whichever order."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path

import pytest
from course.correct import CORRECT
from course.mistakes import WRITINGS

from app.command_line import main
from app.course.class_command import as_csv, grade_class, submissions
from app.lab.workers import LocalWorkers
from robot.settings import SettingError

WRONG = next(item for item in WRITINGS if item.lesson == 1)
FORKS = "import os\n\n\ndef odometry(pose, left, right, track):\n    os._exit(3)\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A class as a learning platform hands it out: a folder a student."""
    path = tmp_path_factory.mktemp("class")
    files = {
        "ada": next(iter(CORRECT.values())),
        "ben": WRONG.source,
        "cleo": FORKS,
        "dan": "x" * 300_000,
        "eve": "",
    }
    for name, source in files.items():
        (path / name).mkdir()
        (path / name / "my_filter.py").write_text(source)
    (path / "notes.txt").write_text("not of Python")
    return path


def table(folder: Path, count: int, *, backwards: bool = False) -> str:
    given = submissions([folder])[:: -1 if backwards else 1]
    workers = LocalWorkers(count)
    try:
        graded = grade_class(given, (1, 2), None, 3, workers)
    finally:
        workers.close()
    return as_csv(graded, (1, 2))


def test_each_file_is_graded_and_one_that_cannot_be_is_told(folder):
    rows = {row["file"]: row for row in csv.DictReader(io.StringIO(table(folder, 2)))}
    assert list(rows) == [f"{name}/my_filter.py" for name in ("ada", "ben", "cleo", "dan", "eve")]
    one = [row["lesson 1"] for row in rows.values()]
    assert one == ["passed", WRONG.code, "stopped", "", ""]
    assert [row["lesson 2"] for row in rows.values()] == ["passed", "passed", "", "", ""]
    problems = [row["problem"] for row in rows.values()]
    assert "valid are up to" in problems.pop(3)
    assert set(problems) == {""}


def test_neither_workers_nor_order_change_a_byte(folder):
    two = table(folder, 2)
    assert table(folder, 1) == two
    head, *rows = table(folder, 2, backwards=True).splitlines()
    assert [head, *rows[::-1]] == two.splitlines()


def test_the_command_tells_a_row_a_file(folder, tmp_path, capsys):
    out = tmp_path / "class.csv"
    words = ["check", str(folder), "--lesson", "1", "--csv", str(out), "--language", "en"]
    assert main(words) == 1
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == ["1"]
    assert [line.split()[1] for line in lines[1:4]] == ["✓", "✗", "✗"]
    assert "300000 bytes" in lines[4]
    assert lines[5].split()[1] == "·"
    assert out.read_text().startswith("file,lesson 1,problem\nada/my_filter.py,passed,\n")
    files = [str(folder / name / "my_filter.py") for name in ("ada", "ben")]
    assert main(["check", *files, "--lesson", "1", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [found[name]["passed"] for name in files] == [True, False]


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["{folder}", "--junit", "x.xml"], "--junit is for one file"),
        (["{folder}/ada/my_filter.py", "--csv", "x.csv"], "--csv is for several files"),
        (["{folder}", "--workers", "2", "--cluster", "tcp://127.0.0.1:1"], "--workers is for this"),
        (["{folder}", "--workers", "0"], "valid is 1 or more"),
    ],
)
def test_options_that_do_nothing_are_refused(folder, capsys, words, complaint):
    assert main(["check", *(word.format(folder=folder) for word in words)]) == 2
    assert complaint in capsys.readouterr().err


def test_a_folder_without_files_is_told(tmp_path):
    with pytest.raises(SettingError, match=r"no file that ends with \.py"):
        submissions([tmp_path])
