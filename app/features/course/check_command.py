"""``brickpose check``: what a lesson's code does wrong."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from app.features.course.class_command import Graded, as_csv, as_table, grade_class, submissions
from app.features.course.grading import SEED, grade_lessons
from app.features.course.language import language_asked
from app.features.course.lesson import lesson_of, lessons
from app.features.course.reports import (
    as_gradescope,
    as_json,
    as_junit,
    as_junit_of_class,
    for_people,
)
from app.features.course.source import read_source
from app.features.lab.workers import workers_from_options
from app.files import atomic_file
from app.languages.catalogue import Catalogue
from app.result_files import require_writable
from robot.settings import SettingError

FILE_ONLY = ("gradescope",)
WRITTEN = ("junit", "gradescope")
CLASS_ONLY = ("csv", "workers", "cluster")


def check(parsed: argparse.Namespace) -> int:
    """Grade a file, or those of a class; return 0 if all that was begun passed, 1 if not."""
    language = language_asked(parsed)
    folder = getattr(parsed, "lessons", None)
    number = getattr(parsed, "lesson", None)
    chosen = lessons(folder) if number is None else [lesson_of(number, folder)]
    seed = getattr(parsed, "seed", SEED)
    if len(parsed.files) > 1 or parsed.files[0].is_dir():
        return _check_class(parsed, [item.number for item in chosen], seed, language)
    for name in CLASS_ONLY:
        if name in parsed:
            raise SettingError(f"--{name} is for several files, or a folder")
    for name in WRITTEN:
        if name in parsed:
            require_writable(getattr(parsed, name))
    [file] = parsed.files
    source = read_source(file)
    results = grade_lessons(source, file.name, chosen, seed)
    summary = as_json(results, language)
    if "json" in parsed:
        sys.stdout.write(json.dumps(summary, indent=2, ensure_ascii=False) + "\n")
    else:
        sys.stdout.write(for_people(results, language))
    if "junit" in parsed:
        _write(parsed.junit, as_junit(results, language))
    if "gradescope" in parsed:
        _write(parsed.gradescope, as_gradescope(results, language))
    return 0 if summary["passed"] else 1


def _check_class(
    parsed: argparse.Namespace, numbers: list[int], seed: int, language: Catalogue
) -> int:
    for name in FILE_ONLY:
        if name in parsed:
            raise SettingError(
                f"--{name} is for one file; --csv, --json and --junit are for several"
            )
    for name in ("csv", "junit"):
        if name in parsed:
            require_writable(getattr(parsed, name))
    workers = workers_from_options(vars(parsed))
    try:
        folder = getattr(parsed, "lessons", None)
        graded = grade_class(submissions(parsed.files), numbers, folder, seed, workers)
    finally:
        workers.close()
    if "json" in parsed:
        summary = {item.name: as_json(item.results, language) | _problem(item) for item in graded}
        sys.stdout.write(json.dumps(summary, indent=2, ensure_ascii=False) + "\n")
    else:
        sys.stdout.write(as_table(graded, numbers, language))
    if "csv" in parsed:
        _write(parsed.csv, as_csv(graded, numbers))
    if "junit" in parsed:
        files = ((item.name, item.results, item.problem) for item in graded)
        _write(parsed.junit, as_junit_of_class(files, language))
    return 0 if all(item.passed for item in graded) else 1


def _problem(item: Graded) -> dict[str, str]:
    return {"problem": item.problem} if item.problem else {}


def _write(path: Path, text: str) -> None:
    with atomic_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
