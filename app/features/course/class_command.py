"""``brickpose check`` of several files: grades a whole class on parallel workers."""

from __future__ import annotations

import csv
import errno
import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from app.features.course.grader.finding import LessonResult
from app.features.course.grading import grade_lessons
from app.features.course.lesson import lesson_of
from app.features.course.source import read_source
from app.features.lab.workers import Workers
from app.languages.catalogue import Catalogue
from robot.settings import SettingError

NO_WORK = ("__MACOSX", "__pycache__", "site-packages")
"""Folders of files that no student wrote: copies by macOS, and Python's own."""


@dataclass(frozen=True)
class Submission:
    """A student's file."""

    name: str
    """Its path below the given folder, which tells whose file it is."""
    file: Path
    """The file; or the student's folder, if there is none in it that ends with .py."""


@dataclass(frozen=True)
class Graded:
    """The result of a student's file."""

    name: str
    results: tuple[LessonResult, ...] = ()
    problem: str = ""
    """Why the file could not be graded; empty if it was graded."""

    @property
    def passed(self) -> bool:
        """Whether the student has begun a lesson, and all begun lessons passed."""
        begun = [result for result in self.results if result.started]
        return not self.problem and bool(begun) and all(result.passed for result in begun)


@dataclass(frozen=True)
class _Job:
    source: str
    path: str
    lessons: tuple[int, ...]
    folder: Path | None
    seed: int


def submissions(given: Sequence[Path]) -> list[Submission]:
    """Return the given files, and all Python files in and below the given folders.

    Where each student has a folder, one that has only other files is returned itself, so that
    nobody is missing in silence.

    Raises:
        SettingError: there is no file.
    """
    result = []
    for path in given:
        if path.is_dir():
            files, closed = _below(path)
            handed_in = [item for item in files if item.suffix.lower() == ".py" and _is_file(item)]
            begun = {item.relative_to(path).parts[0] for item in handed_in}
            if handed_in and all((path / name).is_dir() for name in begun):
                names = {item.relative_to(path).parts[0] for item in (*files, *closed)}
                handed_in += [path / name for name in names - begun if (path / name).is_dir()]
            for item in sorted(handed_in):
                result.append(Submission(item.relative_to(path).as_posix(), item))
        else:
            result.append(Submission(path.as_posix(), path))
    if not result:
        raise SettingError(f"{', '.join(map(str, given))}: there is no file that ends with .py")
    return result


def _below(folder: Path) -> tuple[list[Path], list[Path]]:
    """Return the files below a folder that a person wrote, and folders that may not be read.

    Nobody wrote hidden ones, as macOS and Jupyter leave them beside the files they are of, and what
    belongs to Python.
    """
    closed: list[Path] = []
    files: list[Path] = []
    for place, _, names in os.walk(folder, onerror=lambda e: closed.append(Path(e.filename))):
        files += [Path(place, name) for name in names]

    def by_hand(path: Path) -> bool:
        parts = path.relative_to(folder).parts
        return not any(part[0] == "." or part in NO_WORK for part in parts)

    return list(filter(by_hand, files)), list(filter(by_hand, closed))


def _is_file(path: Path) -> bool:
    """Whether it is a file, or may be one: why it cannot be read is told when it is read."""
    try:
        return path.is_file()
    except PermissionError:
        return True


def grade_class(
    given: Sequence[Submission],
    numbers: Sequence[int],
    folder: Path | None,
    seed: int,
    workers: Workers,
) -> list[Graded]:
    """Grade lessons of many files; the workers and their order do not change a result.

    Args:
        given: the files; a file that cannot be read gets that as its result.
        numbers: the numbers of the lessons.
        folder: a teacher's own lessons.
        seed: seed of the cases.
        workers: the workers that grade.
    """
    texts = [_text(item.file) for item in given]
    jobs = [
        (place, _Job(text, item.file.name, tuple(numbers), folder, seed))
        for place, (item, text) in enumerate(zip(given, texts, strict=True))
        if isinstance(text, str)
    ]
    results: dict[int, tuple[LessonResult, ...]] = {}
    problems = {place: str(text) for place, text in enumerate(texts) if not isinstance(text, str)}
    for index, result in workers.each(_grade, [job for _, job in jobs]):
        place, _ = jobs[index]
        if isinstance(result, Exception):
            problems[place] = f"{type(result).__name__}: {result}"
        else:
            results[place] = result
    return [
        Graded(item.name, results.get(place, ()), problems.get(place, ""))
        for place, item in enumerate(given)
    ]


def _text(file: Path) -> str | SettingError:
    if file.suffix.lower() != ".py" and file.is_dir():
        others, closed = _below(file)
        if file in closed or not others:
            return SettingError(f"{file} cannot be read: {os.strerror(errno.EACCES)}")
        listed = ", ".join(sorted(item.name for item in others))
        return SettingError(f"there is no file that ends with .py, but {listed[:120]}")
    try:
        return read_source(file)
    except SettingError as error:
        return error


def _grade(job: _Job) -> tuple[LessonResult, ...]:
    chosen = [lesson_of(number, job.folder) for number in job.lessons]
    return tuple(grade_lessons(job.source, job.path, chosen, job.seed))


def as_table(graded: Sequence[Graded], numbers: Sequence[int], language: Catalogue) -> str:
    """Return a table with a row for each file and a column for each lesson."""
    width = max(len(item.name) for item in graded)
    lines = [" " * width + "".join(f"{number:>4}" for number in numbers)]
    for item in graded:
        marks = "".join(f"{_mark(result):>4}" for result in item.results)
        lines.append(f"{item.name:{width}}{marks if not item.problem else '   ' + item.problem}")
    lines += ["", language.t("✓ passed, ✗ not yet, · not begun")]
    return "\n".join(lines) + "\n"


def _mark(result: LessonResult) -> str:
    return "✓" if result.passed else "✗" if result.started else "·"


def as_csv(graded: Sequence[Graded], numbers: Sequence[int]) -> str:
    """Return a row for each file: for each lesson ``passed``, the causes found, or nothing."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["file", *(f"lesson {number}" for number in numbers), "problem"])
    for item in graded:
        cells = {result.lesson: _cell(result) for result in item.results}
        writer.writerow([item.name, *(cells.get(n, "") for n in numbers), item.problem])
    return text.getvalue()


def _cell(result: LessonResult) -> str:
    if result.passed:
        return "passed"
    return " ".join(dict.fromkeys(finding.cause for finding in result.findings))
