"""``brickpose learn``: the dashboard, and a lesson beside it."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from app.console import say
from app.feature import Feature
from app.features.course.language import language_asked
from app.features.course.lesson import lesson_of, lessons, starting_file
from app.features.course.routes import course_router
from app.page.run_command import run_dashboard
from app.settings.config import Config, with_settings

FIELD_OF_LESSON = {8: "stub"}
"""Where the default field would show the lesson's point never: its places look alike."""
BY_PARTICLES = range(1, 7)
"""Lessons that begin with the filter that they teach; the others need one that follows several
places."""


def suited(config: Config, lesson: int, *, map_given: bool) -> Config:
    """Return settings with the field and the filter of a lesson, where nobody asked for others."""
    usual = Config()
    field = FIELD_OF_LESSON.get(lesson)
    if field is not None and not map_given and config.map == usual.map:
        config = replace(config, map=field)
    if lesson in BY_PARTICLES and config.localization == usual.localization:
        config = with_settings(config, {"localization.filter.filter": "particles"})
    return config


def learn(parsed: argparse.Namespace, config: Config) -> int:
    """Serve the dashboard with a lesson beside it; begin the student's file if there is none.

    Raises:
        SettingError: there is no such lesson, or language.
    """
    folder = getattr(parsed, "lessons", None)
    chosen = lesson_of(parsed.lesson, folder)
    config = suited(config, chosen.number, map_given="map" in parsed)
    language = language_asked(parsed)
    file: Path = parsed.file.absolute()
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(starting_file(lessons(folder), language), encoding="utf-8")
        say(language.t("{file} is new: write your functions there, with any editor", file=file))
    if not config.models:
        config = replace(config, models=str(file.parent))
    beside = Feature(
        name="lessons",
        about="the lessons of this file",
        routers=(lambda _program: course_router(file, folder),),
    )
    return run_dashboard(parsed, config, parsed.features.adding(beside), f"/learn/{chosen.number}")
