"""``brickpose check`` of several files: grades a whole class on parallel workers."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from app.course.grader.finding import Result
from app.course.grading import grade
from app.course.lesson import lesson_of
from app.course.source import read_source
from app.lab.workers import Workers
from app.languages.catalogue import Catalogue
from robot.settings import SettingError


@dataclass(frozen=True)
class Submission:
    """A student's file."""

    name: str
    """Its path below the given folder, which tells whose file it is."""
    file: Path


@dataclass(frozen=True)
class Graded:
    """The result of a student's file."""

    name: str
    results: tuple[Result, ...] = ()
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
    lesson: int
    folder: Path | None
    seed: int


def submissions(given: Sequence[Path]) -> list[Submission]:
    """Return the given files, and all Python files in and below the given folders.

    Raises:
        SettingError: there is no file.
    """
    result = []
    for path in given:
        if path.is_dir():
            files = sorted(item for item in path.rglob("*.py") if item.is_file())
            result += [Submission(item.relative_to(path).as_posix(), item) for item in files]
        else:
            result.append(Submission(path.as_posix(), path))
    if not result:
        raise SettingError(f"{', '.join(map(str, given))}: there is no file that ends with .py")
    return result


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
        (place, _Job(text, item.file.name, number, folder, seed))
        for place, (item, text) in enumerate(zip(given, texts, strict=True))
        if isinstance(text, str)
        for number in numbers
    ]
    results: dict[int, dict[int, Result]] = {}
    problems = {place: str(text) for place, text in enumerate(texts) if not isinstance(text, str)}
    for index, result in workers.each(_grade, [job for _, job in jobs]):
        place, job = jobs[index]
        if isinstance(result, Exception):
            problems[place] = f"{type(result).__name__}: {result}"
        else:
            results.setdefault(place, {})[job.lesson] = result
    return [
        Graded(item.name, _in_order(results.get(place, {}), numbers), problems.get(place, ""))
        for place, item in enumerate(given)
    ]


def _text(file: Path) -> str | SettingError:
    try:
        return read_source(file)
    except SettingError as error:
        return error


def _in_order(results: Mapping[int, Result], numbers: Sequence[int]) -> tuple[Result, ...]:
    return tuple(results[number] for number in numbers if number in results)


def _grade(job: _Job) -> Result:
    return grade(job.source, job.path, lesson_of(job.lesson, job.folder), job.seed)


def as_table(graded: Sequence[Graded], numbers: Sequence[int], language: Catalogue) -> str:
    """Return a table with a row for each file and a column for each lesson."""
    width = max(len(item.name) for item in graded)
    lines = [" " * width + "".join(f"{number:>4}" for number in numbers)]
    for item in graded:
        marks = "".join(f"{_mark(result):>4}" for result in item.results)
        lines.append(f"{item.name:{width}}{marks if not item.problem else '   ' + item.problem}")
    lines += ["", language.t("✓ passed, ✗ not yet, · not begun")]
    return "\n".join(lines) + "\n"


def _mark(result: Result) -> str:
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


def _cell(result: Result) -> str:
    if result.passed:
        return "passed"
    return " ".join(dict.fromkeys(finding.cause for finding in result.findings))
