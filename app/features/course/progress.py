"""Progress: which lessons a student has begun and passed, kept beside the student's file."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path
from typing import Any

from app.features.course.grader.finding import LessonResult
from app.files import atomic_file

NAME = ".brickpose-progress.json"
LONGEST = 100_000


class Progress:
    """Lessons by number; it lasts when another browser, or another computer, opens the course."""

    def __init__(self, file: Path) -> None:
        """Read what is kept beside a student's ``file``; nothing, if that cannot be read."""
        self._path = file.parent / NAME
        kept: Any = {}
        with suppress(OSError, ValueError):
            if self._path.stat().st_size < LONGEST:
                kept = json.loads(self._path.read_text(encoding="utf-8"))
        kept = kept if isinstance(kept, dict) else {}
        self.passed = _numbers(kept.get("passed"))
        """Those that have passed once, whatever the file has become."""
        self.begun = _numbers(kept.get("begun"))
        self.lesson: int | None = next(iter(_numbers([kept.get("lesson")])), None)
        """The lesson on the page, or that was there last."""

    def note(self, result: LessonResult) -> None:
        """Keep how a lesson stands; a folder that cannot be written to keeps it for now only."""
        before = self.to_json()
        self.lesson = result.lesson
        if result.started:
            self.begun.add(result.lesson)
        if result.passed:
            self.passed.add(result.lesson)
        self._keep(before)

    def open(self, lesson: int) -> None:
        """Keep which lesson is on the page, as that is so before anything of it is checked."""
        before = self.to_json()
        self.lesson = lesson
        self._keep(before)

    def _keep(self, before: dict[str, Any]) -> None:
        if self.to_json() != before:
            with suppress(OSError), atomic_file(self._path) as unfinished:
                unfinished.write_text(json.dumps(self.to_json()), encoding="utf-8")

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return {
            "lesson": self.lesson,
            "passed": sorted(self.passed),
            "begun": sorted(self.begun | self.passed),
        }


def _numbers(values: object) -> set[int]:
    each = values if isinstance(values, list) else []
    return {value for value in each if type(value) is int and 0 < value < 1000}
