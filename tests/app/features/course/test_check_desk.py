"""The desk tells in words what cannot be checked, and ends with its page."""

from __future__ import annotations

from pathlib import Path

import anyio
from starlette.websockets import WebSocket

from app.features.course.desk import CheckDesk
from app.languages.catalogue import catalogue


def told(file: Path, number: int, lessons: Path | None = None) -> dict:
    return dict(anyio.run(CheckDesk(file, lessons).result, number, catalogue("en")))


def test_what_cannot_be_checked_is_told_in_words(tmp_path) -> None:
    file, lesson = tmp_path / "mine.py", tmp_path / "lessons" / "70_broken"
    assert "cannot be read" in told(file, 1)["message"]
    file.write_text("")
    assert "there is no lesson 99" in told(file, 99)["message"]
    lesson.mkdir(parents=True)
    (lesson / "checks.py").write_text("1 / 0")
    problem = told(file, 70, lesson.parent)
    assert problem["type"] == "problem"
    assert "checks.py fails: ZeroDivisionError" in problem["message"]


def test_a_page_that_is_gone_ends_its_task(tmp_path) -> None:
    sent = []

    async def receive() -> dict:
        if not sent:
            return {"type": "websocket.connect"}
        await anyio.sleep_forever()
        raise AssertionError

    async def send(message: dict) -> None:
        sent.append(message)
        if message["type"] == "websocket.send":
            raise OSError

    scope = {"type": "websocket", "headers": [], "path": "/"}
    socket = WebSocket(scope, receive, send)  # type: ignore[arg-type]

    async def serve() -> None:
        with anyio.fail_after(10):
            await CheckDesk(tmp_path / "mine.py", None).serve(socket, 1)

    anyio.run(serve)
    assert [item["type"] for item in sent] == ["websocket.accept", "websocket.send"]
