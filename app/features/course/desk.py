"""Checks a student's file at each save, for the pages that show a lesson."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import anyio
from anyio import to_thread
from fastapi import WebSocket, WebSocketDisconnect

from app.features.course.grader.finding import LessonResult
from app.features.course.grading import grade
from app.features.course.lesson import lesson_of
from app.features.course.progress import Progress
from app.features.course.source import read_source
from app.features.own_models.watch import signature
from app.languages.catalogue import Catalogue
from app.page.language import language_of
from robot.settings import SettingError

LOOK_S = 0.15
"""Interval of looking at the file [s]."""
MOST_KEPT = 100
"""How many results are kept, for other pages that show the same."""


class CheckDesk:
    """Watches one file; grades one lesson at a time, whoever asks."""

    def __init__(self, file: Path, folder: Path | None) -> None:
        """Watch a file; ``folder`` has a teacher's own lessons."""
        self.file = file
        self.folder = folder
        self.progress = Progress(file)
        self._results: dict[tuple[str, int], LessonResult] = {}
        self._turn = asyncio.Lock()

    async def serve(self, socket: WebSocket, number: int) -> None:
        """Send a page how a lesson stands, now and after each save, until it leaves."""
        await socket.accept()
        language = language_of(socket)
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(self._until_gone, socket, tasks.cancel_scope)
            with suppress(WebSocketDisconnect):  # outside, it would be one error of a group
                await self._follow(socket, number, language)
            tasks.cancel_scope.cancel()

    async def _until_gone(self, socket: WebSocket, scope: anyio.CancelScope) -> None:
        try:
            while True:
                await socket.receive_text()
        except (WebSocketDisconnect, RuntimeError, KeyError):
            scope.cancel()

    async def _follow(self, socket: WebSocket, number: int, language: Catalogue) -> None:
        shown: object = object()
        while True:
            current = signature(self.file)
            if current != shown:
                shown = current
                await socket.send_json({"type": "checking", "file": self.file.name})
                await socket.send_json(await self.result(number, language))
            await anyio.sleep(LOOK_S)

    async def result(self, number: int, language: Catalogue) -> Mapping[str, Any]:
        """Return how a lesson of the file stands, as the page shows it."""
        try:
            result = await self._graded(number)
        except SettingError as error:
            return {"type": "problem", "message": language.translated(str(error))}
        self.progress.note(result)
        return {
            "type": "result",
            "file": self.file.name,
            "passed": result.passed,
            "begun": result.started,
            "findings": [finding.to_json(language) for finding in result.findings],
        }

    async def _graded(self, number: int) -> LessonResult:
        source = await to_thread.run_sync(read_source, self.file)
        async with self._turn:
            result = self._results.get((source, number))
            if result is None:
                lesson = lesson_of(number, self.folder)
                result = await to_thread.run_sync(grade, source, self.file.name, lesson)
                self._keep(source, number, result)
        return result

    def _keep(self, source: str, number: int, result: LessonResult) -> None:
        if len(self._results) >= MOST_KEPT:
            self._results.pop(next(iter(self._results)))
        self._results[source, number] = result
