"""Routes below ``/learn``: the lessons' page, what they say, and how the student's file stands."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from fastapi import APIRouter, HTTPException, Request, Response, WebSocket
from fastapi.responses import HTMLResponse

from app.features.course.desk import CheckDesk
from app.features.course.lesson import Lesson, lesson_of, lessons
from app.features.course.lesson_text import parsed
from app.features.course.student_file import student_file_router
from app.languages.catalogue import Catalogue
from app.messages.answers import content, refusal
from app.page.language import language_of, page
from app.page.people import know
from app.page.token_guard import role_in
from app.page.tokens import Role
from app.settings.config import FRONTEND
from robot.settings import SettingError

NO_LESSON = refusal(404, "no such lesson")
PAGE = FRONTEND / "features" / "course" / "learn.html"


def course_router(file: Path, folder: Path | None = None) -> APIRouter:
    """Serve the lessons beside the dashboard.

    Args:
        file: the student's file, which is checked at each save.
        folder: a teacher's own lessons.
    """
    router, desk = APIRouter(), CheckDesk(file, folder)

    router.include_router(student_file_router(file))

    @router.get("/learn", include_in_schema=False)
    def first(request: Request) -> HTMLResponse:
        answer = page(PAGE, request)
        know(request, answer)
        return answer

    @router.get("/learn/{number}", include_in_schema=False)
    def learn(request: Request, number: int) -> HTMLResponse:
        _lesson(number, folder)
        answer = page(PAGE, request, content={"base": '<base href="../">'})
        know(request, answer)
        return answer

    @router.get("/api/lessons")
    def all_lessons(request: Request) -> list[dict[str, Any]]:
        """All lessons, by number and title, and whether they have passed once."""
        language, passed = language_of(request).language, desk.progress.passed
        return [
            {
                "number": item.number,
                "title": parsed(item.text(language)).title,
                "passed": item.number in passed,
            }
            for item in lessons(folder)
        ]

    @router.get("/api/progress")
    def progress() -> dict[str, Any]:
        """Numbers of the lesson at hand, and of those that were begun and have passed."""
        return desk.progress.to_json()

    @router.get("/api/lessons/{number}", responses=NO_LESSON)
    def lesson_text(number: int, request: Request) -> dict[str, Any]:
        """A lesson's text in the page's language, in sections of HTML."""
        lesson, drives = _lesson(number, folder), role_in(request.scope) is Role.DRIVE
        if drives:
            desk.progress.open(number)
        # Who watches needs no path of this computer.
        shown = file if drives else Path(file.name)
        return _content(lesson, language_of(request), shown)

    @router.get("/api/lessons/{number}/picture.svg", response_class=Response,
                responses=NO_LESSON | content("image/svg+xml"))  # fmt: skip
    def picture(number: int) -> Response:
        """A lesson's picture."""
        path = _lesson(number, folder).folder / "picture.svg"
        if not path.is_file():
            raise HTTPException(404, f"lesson {number} has no picture")
        return Response(path.read_bytes(), media_type="image/svg+xml")

    @router.websocket("/api/lessons/{number}/checks")
    async def checks(socket: WebSocket, number: int) -> None:
        await desk.serve(socket, number)

    return router


def _lesson(number: int, folder: Path | None) -> Lesson:
    try:
        return lesson_of(number, folder)
    except SettingError as error:
        raise HTTPException(404, str(error)) from error


def _content(lesson: Lesson, language: Catalogue, file: Path) -> dict[str, Any]:
    text = parsed(lesson.text(language.language))
    return {
        "number": lesson.number,
        "title": text.title,
        "html": text.html,
        "sections": [
            {"title": item.title, "html": item.html, "choices": list(item.choices)}
            for item in text.sections
        ],
        "stub": lesson.stub(language),
        "picture": (lesson.folder / "picture.svg").is_file(),
        "file": str(file),
    }
