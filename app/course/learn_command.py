"""``brickpose learn``: the dashboard, and a lesson beside it."""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

from fastapi import APIRouter

from app.console import say
from app.course.language import language_asked
from app.course.lesson import lesson_of, lessons, starting_file
from app.course.routes import course_router
from app.settings.config import Config


def prepare(parsed: argparse.Namespace, config: Config) -> tuple[Config, APIRouter, str]:
    """Begin the student's file if there is none; return settings, routes, and the page's path.

    Raises:
        SettingError: there is no such lesson, or language.
    """
    folder = getattr(parsed, "lessons", None)
    chosen = lesson_of(parsed.lesson, folder)
    language = language_asked(parsed)
    file: Path = parsed.file.absolute()
    if not file.exists():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(starting_file(lessons(folder), language), encoding="utf-8")
        say(language.t("{file} is new: write your functions there, with any editor", file=file))
    if not config.models:
        config = replace(config, models=str(file.parent))
    return config, course_router(file, folder), f"/learn/{chosen.number}"
