"""What a student has begun and passed lasts beside the file, whatever becomes of that."""

from __future__ import annotations

import pytest

from app.features.course.grader.finding import LessonResult
from app.features.course.progress import NAME, Progress


def result(lesson: int, *, started: bool = True, passed: bool = False) -> LessonResult:
    return LessonResult(lesson, "x", () if passed or not started else ("flaw",), started)


def test_it_lasts_and_a_lesson_that_passed_once_stays_so(tmp_path):
    file = tmp_path / "my_filter.py"
    first = Progress(file)
    first.note(result(1, passed=True))
    first.note(result(2))
    first.note(result(1))
    first.note(result(4, started=False))
    assert Progress(file).to_json() == {"lesson": 4, "passed": [1], "begun": [1, 2]}


@pytest.mark.parametrize("kept", ["{", "[]", '{"passed": 3, "begun": ["x", -1], "lesson": "a"}'])
def test_what_cannot_be_read_is_nothing(tmp_path, kept):
    (tmp_path / NAME).write_text(kept)
    assert Progress(tmp_path / "mine.py").to_json() == {"lesson": None, "passed": [], "begun": []}


def test_a_folder_that_is_full_or_gone_costs_only_the_keeping(tmp_path):
    progress = Progress(tmp_path / "gone" / "mine.py")
    progress.note(result(1, passed=True))
    assert progress.passed == {1}
