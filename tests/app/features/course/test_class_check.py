"""``brickpose check`` of a class: many files, the same whoever grades them in whichever order."""

from __future__ import annotations

import csv
import errno
import io
import json
import os
from pathlib import Path
from xml.etree import ElementTree

import pytest
from course.correct import CORRECT
from course.mistakes import WRITINGS

from app.command_line import main
from app.features.course.class_command import as_csv, grade_class, submissions
from app.features.lab.workers import LocalWorkers
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


@pytest.mark.slow
def test_each_file_is_graded_and_one_that_cannot_be_is_told(folder):
    rows = {row["file"]: row for row in csv.DictReader(io.StringIO(table(folder, 2)))}
    assert list(rows) == [f"{name}/my_filter.py" for name in ("ada", "ben", "cleo", "dan", "eve")]
    one = [row["lesson 1"] for row in rows.values()]
    assert one == ["passed", WRONG.code, "stopped", "", ""]
    assert [row["lesson 2"] for row in rows.values()] == ["passed", "passed", "", "", ""]
    problems = [row["problem"] for row in rows.values()]
    assert "valid are up to" in problems.pop(3)
    assert set(problems) == {""}


@pytest.mark.slow
def test_neither_workers_nor_order_change_a_byte(folder):
    two = table(folder, 2)
    assert table(folder, 1) == two
    head, *rows = table(folder, 2, backwards=True).splitlines()
    assert [head, *rows[::-1]] == two.splitlines()


@pytest.mark.slow
def test_the_command_tells_a_row_a_file(folder, tmp_path, capsys):
    out = tmp_path / "class.csv"
    junit = tmp_path / "class.xml"
    words = ["check", str(folder), "--lesson", "1", "--csv", str(out), "--language", "en"]
    assert main([*words, "--junit", str(junit)]) == 1
    suites = ElementTree.parse(junit).getroot().findall("testsuite")
    assert suites[0].get("name") == "ada/my_filter.py"
    counted = [[suite.get(name, "0") for name in ("failures", "skipped")] for suite in suites]
    assert counted[0] == ["0", "0"]
    assert counted[1][0] != "0"
    assert sum(suite.get("errors") == "1" for suite in suites) == 1, "the file that is too long"
    assert counted[-1] == ["0", "1"]
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
        (["{folder}", "--gradescope", "x.json"], "--gradescope is for one file"),
        (["{folder}/ada/my_filter.py", "--csv", "x.csv"], "--csv is for several files"),
        (["{folder}", "--workers", "2", "--cluster", "tcp://127.0.0.1:1"], "--workers is for this"),
        (["{folder}", "--workers", "0"], "valid is 1 or more"),
    ],
)
def test_options_that_do_nothing_are_refused(folder, capsys, words, complaint):
    assert main(["check", *(word.format(folder=folder) for word in words)]) == 2
    assert complaint in capsys.readouterr().err


@pytest.mark.slow
def test_a_class_from_a_mac_has_a_row_a_student(tmp_path):
    """What macOS, Jupyter and Python leave is nobody's work; who has no .py is not left out."""
    apple = b"\0\5\x16\7\0\2\0\0Mac OS X        " + bytes(99)
    source = next(iter(CORRECT.values())).encode()
    files = {
        "__MACOSX/ada/._my_filter.py": apple,
        ".git/hooks/pre-commit.py": b"x = 1",
        "ada/._my_filter.py": apple,
        "ada/my_filter.py": source,
        "ben/.ipynb_checkpoints/my_filter-checkpoint.py": source,
        "ben/My Filter (1).PY": source,
        "ben/venv/lib/python3.11/site-packages/numpy/version.py": b"x = 1",
        "ben/__pycache__/my_filter.cpython-311.py": b"x = 1",
        "cleo/.DS_Store": b"1",
        "cleo/my_filter.py.txt": source,
        "dan/.DS_Store": b"1",
        "notes.txt": b"of the teacher",
    }
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(content)
    rows = {row["file"]: row for row in csv.DictReader(io.StringIO(table(tmp_path, 1)))}
    assert list(rows) == ["ada/my_filter.py", "ben/My Filter (1).PY", "cleo"]
    assert [row["lesson 1"] for row in rows.values()] == ["passed", "passed", ""]
    assert "no file that ends with .py, but my_filter.py.txt" in rows["cleo"]["problem"]


@pytest.mark.slow
def test_who_may_not_be_read_costs_nobody_else(tmp_path, monkeypatch):
    """As platforms leave it: a file, a folder of pictures, or a student's folder is closed."""
    source = next(iter(CORRECT.values()))
    for name in ("ada/my_filter.py", "ben/my_filter.py", "ben/pictures/a.png", "cleo/my_filter.py"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(source)
    (tmp_path / "dan").mkdir()
    closed = [tmp_path / name for name in ("ben/pictures", "cleo/my_filter.py", "dan")]

    def guarded(reads):
        def read(path, *rest):
            if any(Path(path).is_relative_to(place) for place in closed):
                raise PermissionError(errno.EACCES, "Permission denied", str(path))
            return reads(path, *rest)

        return read

    for holder, name in ((os, "scandir"), (Path, "read_bytes"), (Path, "is_file")):
        monkeypatch.setattr(holder, name, guarded(getattr(holder, name)))
    workers = LocalWorkers(1)
    try:
        graded = {
            item.name: item for item in grade_class(submissions([tmp_path]), (1,), None, 3, workers)
        }
    finally:
        workers.close()
    assert list(graded) == ["ada/my_filter.py", "ben/my_filter.py", "cleo/my_filter.py", "dan"]
    assert [item.passed for item in graded.values()] == [True, True, False, False]
    for name in ("cleo/my_filter.py", "dan"):
        assert "cannot be read: Permission denied" in graded[name].problem


def test_where_files_lie_side_by_side_a_folder_is_no_student(tmp_path):
    for name in ("ada.py", "ben.PY", "pictures/logo.png", "notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    assert [item.name for item in submissions([tmp_path])] == ["ada.py", "ben.PY"]


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be", "utf-8-sig"])
def test_a_file_in_the_encodings_of_windows_is_graded(tmp_path, capsys, encoding):
    """PowerShell's ``>`` writes UTF-16, and so does Notepad's "Unicode"."""
    file = tmp_path / "mine.py"
    mark = "\ufeff" if encoding == "utf-16-be" else ""
    file.write_text(f"{mark}# Größe\n{next(iter(CORRECT.values()))}", encoding=encoding)
    assert main(["check", str(file), "--lesson", "1"]) == 0
    assert "passed" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"PK\3\4\0\0\0\0", "is an archive; unpack it; valid is Python code"),
        (b"\0\5\x16\7\0\2\0\0Mac OS X", "is no text; valid is Python code, saved as UTF-8"),
        ("x = 1".encode("utf-16-le"), "is no text; valid is Python code, saved as UTF-8"),
    ],
)
def test_what_is_no_text_is_told_as_that(tmp_path, capsys, content, words):
    file = tmp_path / "mine.py"
    file.write_bytes(content)
    assert main(["check", str(file), "--lesson", "1"]) == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize("of_a_class", [True, False])
def test_results_that_cannot_be_written_are_told_before_anything_is_graded(
    folder, tmp_path, capsys, of_a_class
):
    (tmp_path / "file").touch()
    (tmp_path / "taken").mkdir()
    given = folder if of_a_class else folder / "ada" / "my_filter.py"
    option = "--csv" if of_a_class else "--junit"
    for out in (tmp_path / "file" / "out", tmp_path / "taken"):
        assert main(["check", str(given), option, str(out)]) == 2
        told = capsys.readouterr()
        assert told.err.startswith(f"brickpose: {out} cannot be written: ")
        assert told.out == ""
    assert sorted(item.name for item in tmp_path.iterdir()) == ["file", "taken"]


def test_a_folder_without_files_is_told(tmp_path):
    with pytest.raises(SettingError, match=r"no file that ends with \.py"):
        submissions([tmp_path])
