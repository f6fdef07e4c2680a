"""``brickpose check``: what a lesson's code does wrong."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from app.course.grading import SEED, grade
from app.course.lesson import lesson_of, lessons
from app.course.reports import as_gradescope, as_json, as_junit, for_people
from app.files import atomic_file
from app.languages.catalogue import Catalogue, catalogue, languages, spoken
from robot.settings import SettingError

LONGEST = 200_000
"""Longer files are refused [bytes]: no lesson needs a tenth of it."""


def check(parsed: argparse.Namespace) -> int:
    """Grade a file; return 0 if all that was begun passed, 1 if not."""
    language = _language(getattr(parsed, "language", None))
    folder = getattr(parsed, "lessons", None)
    number = getattr(parsed, "lesson", None)
    chosen = lessons(folder) if number is None else [lesson_of(number, folder)]
    source = read_source(parsed.file)
    seed = getattr(parsed, "seed", SEED)
    results = [grade(source, parsed.file.name, lesson, seed) for lesson in chosen]
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


def read_source(path: Path) -> str:
    """Return a student's file.

    Raises:
        SettingError: it cannot be read as text.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise SettingError(f"{path} cannot be read: {error.strerror}") from error
    if len(content) > LONGEST:
        raise SettingError(f"{path} has {len(content)} bytes; valid are up to {LONGEST}")
    # What is no UTF-8 becomes a sign that Python refuses, with its line.
    return content.decode("utf-8", errors="replace")


def _language(code: str | None) -> Catalogue:
    if code is None:
        return spoken()
    if code not in languages():
        raise SettingError(f"there is no language {code}; valid are {', '.join(languages())}")
    return catalogue(code)


def _write(path: Path, text: str) -> None:
    with atomic_file(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")
