"""A lesson: a folder with text in each language, a picture, a stub and checks."""

from __future__ import annotations

import importlib.util
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from app.features.course.grader.case import Checks
from app.features.course.grader.words import ENGLISH_TEXTS
from app.languages.catalogue import Catalogue
from app.languages.docstrings import in_language
from app.languages.marking import phrase
from robot.settings import SettingError

LESSONS = Path(__file__).parent / "lessons"
HEAD = f'''"""{phrase("My particle filter; `brickpose learn` explains each function.")}"""

import math
import types

import numpy as np
'''
NAME = re.compile(r"(\d+)_(\w+)")


@dataclass(frozen=True)
class Lesson:
    """One lesson, by its folder ``<number>_<name>``."""

    folder: Path

    @property
    def number(self) -> int:
        """Its number, by which lessons are sorted."""
        return int(self.folder.name.partition("_")[0])

    @property
    def name(self) -> str:
        """Its name, in words."""
        return self.folder.name.partition("_")[2].replace("_", " ")

    @cached_property
    def checks(self) -> Checks:
        """What ``checks.py`` brings.

        Raises:
            SettingError: there is no such file, it fails, or it has no ``CHECKS``.
        """
        path = self.folder / "checks.py"
        spec = importlib.util.spec_from_file_location(f"lesson_{self.number}_checks", path)
        if not path.is_file() or spec is None or spec.loader is None:
            raise SettingError(f"the lesson {self.folder} has no checks.py")
        module = importlib.util.module_from_spec(spec)
        sys.modules[module.__name__] = module
        try:
            spec.loader.exec_module(module)
        except Exception as error:  # a teacher's file may raise any
            raise SettingError(f"{path} fails: {type(error).__name__}: {error}") from error
        checks = getattr(module, "CHECKS", None)
        if not isinstance(checks, Checks):
            raise SettingError(f"{path} has no CHECKS; see docs/course.md")
        return checks

    def text(self, language: str) -> str:
        """Return the lesson in a language, or in English where it has none in that."""
        path = self.folder / f"{language}.md"
        return (path if path.is_file() else self.folder / "en.md").read_text(encoding="utf-8")

    def stub(self, language: Catalogue = ENGLISH_TEXTS) -> str:
        """Return the code that the student starts from, described in a language."""
        return in_language((self.folder / "stub.py").read_text(encoding="utf-8"), language)


def starting_file(chosen: list[Lesson], language: Catalogue = ENGLISH_TEXTS) -> str:
    """Return the file that a student starts from: stubs, and what the dashboard drives with."""
    stubs = [lesson.stub(language).strip() for lesson in chosen]
    given = (LESSONS / "dashboard.py").read_text(encoding="utf-8")
    head, given = (in_language(text, language).strip() for text in (HEAD, given))
    return "\n\n\n".join([head, *stubs, given]) + "\n"


def lessons(folder: Path | None = None) -> list[Lesson]:
    """Return the lessons of the program and of a teacher's folder, by number.

    A teacher's lesson takes the place of the program's with the same number.
    """
    known = {lesson.number: lesson for lesson in _in_folder(LESSONS)}
    if folder is not None:
        known.update({lesson.number: lesson for lesson in _in_folder(folder)})
    return [known[number] for number in sorted(known)]


def lesson_of(number: int, folder: Path | None = None) -> Lesson:
    """Return a lesson by number.

    Raises:
        SettingError: there is none.
    """
    known = {lesson.number: lesson for lesson in lessons(folder)}
    if number not in known:
        numbers = ", ".join(map(str, known))
        raise SettingError(f"there is no lesson {number}; valid are {numbers}")
    return known[number]


def _in_folder(folder: Path) -> Iterator[Lesson]:
    for path in sorted(folder.iterdir()):
        if path.is_dir() and NAME.fullmatch(path.name):
            yield Lesson(path)
