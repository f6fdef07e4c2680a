"""Routes of the wall: what it shows, orders and collects."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any, Literal
from urllib.parse import quote

from fastapi import APIRouter, HTTPException, Request, Response
from fastapi.responses import FileResponse, HTMLResponse
from pydantic import BaseModel, ConfigDict, Field

from app.features.classroom.class_desk import LONGEST_MESSAGE
from app.features.classroom.shared.queue_desk import QueueWish
from app.features.classroom.wall.collecting import Results
from app.features.classroom.wall.followed import TAKEN_S, FollowedServer
from app.features.classroom.wall.wall import Wall
from app.page.language import page
from app.settings.config import FRONTEND

PAGE = FRONTEND / "features" / "classroom" / "wall"
LONGEST_RECORDING = 64 << 20
"""Of a recording that is handed out [bytes]."""


class _Asked(BaseModel):
    model_config = ConfigDict(extra="forbid")
    logins: list[str] | None = None
    """Logins; none is all."""


class Freeze(_Asked):
    """Freezes robots, or lets them go on."""

    frozen: bool


class Say(_Asked):
    """A message to students' pages; empty takes it away."""

    text: Annotated[str, Field(max_length=LONGEST_MESSAGE)]


class StartPlace(_Asked):
    """Puts simulated robots at one place, and tells them so: x, y [m], theta [rad]."""

    x: Annotated[float, Field(allow_inf_nan=False, ge=-100, le=100)]
    y: Annotated[float, Field(allow_inf_nan=False, ge=-100, le=100)]
    theta: Annotated[float, Field(allow_inf_nan=False, ge=-7, le=7)]


class UseLesson(_Asked):
    """Hands out a lesson, by its number; 0 takes it back."""

    number: Annotated[int, Field(ge=0, le=999)]


class UseField(_Asked):
    """Hands out a field."""

    name: Annotated[str, Field(min_length=1, max_length=100)]


def shown_router(wall: Wall) -> APIRouter:
    """Return the routes of the page and of what it shows."""
    router = APIRouter()

    @router.get("/")
    def shown(request: Request) -> HTMLResponse:
        return page(PAGE / "wall.html", request)

    @router.get("/api/queue")
    async def queue() -> dict[str, Any] | None:
        return await wall.queue()

    @router.get("/api/tiles")
    def tiles() -> list[dict[str, Any]]:
        return wall.tiles()

    @router.get("/api/floor/{login}.png")
    async def floor(login: str) -> Response:
        picture = await wall.picture(login)
        if picture is None:
            raise HTTPException(404, f"{login} has no field now")
        return Response(picture, media_type="image/png")

    return router


def orders_router(wall: Wall) -> APIRouter:
    """Return the routes by which the teacher orders all, or some."""
    router = APIRouter()

    @router.post("/api/freeze")
    async def freeze(asked: Freeze) -> dict[str, Any]:
        return await wall.of_each(asked.logins, partial(_order, frozen=asked.frozen))

    @router.post("/api/message")
    async def message(asked: Say) -> dict[str, Any]:
        return await wall.of_each(asked.logins, partial(_order, message=asked.text))

    @router.post("/api/place")
    async def place(asked: StartPlace) -> dict[str, Any]:
        pose = {"x": asked.x, "y": asked.y, "theta": asked.theta}

        async def put(server: FollowedServer) -> str:
            return (
                await server.send(type="stop")
                or await server.send(type="place", **pose)
                or await server.send(type="set_pose", **pose)
            )

        return await wall.of_each(asked.logins, put)

    @router.post("/api/queue")
    async def queue(asked: QueueWish) -> dict[str, Any] | None:
        return await wall.queue({"action": asked.action, "login": asked.login})

    @router.post("/api/start")
    async def start() -> dict[str, int]:
        return {"started": await wall.start_all()}

    return router


def handouts_router(wall: Wall) -> APIRouter:
    """Return the routes by which the teacher hands out fields, lessons and recordings."""
    router = APIRouter()

    @router.post("/api/field")
    async def use_field(asked: UseField) -> dict[str, Any]:
        async def change(server: FollowedServer) -> str:
            return await server.send(TAKEN_S, type="use_field", name=asked.name)

        return await wall.of_each(asked.logins, change)

    @router.post("/api/lesson")
    async def lesson(asked: UseLesson) -> dict[str, Any]:
        return await wall.of_each(asked.logins, partial(_order, lesson=asked.number))

    @router.put("/api/recordings/{name}")
    async def recording(name: str, request: Request) -> dict[str, Any]:
        content = b""
        async for part in request.stream():
            content += part
            if len(content) > LONGEST_RECORDING:
                raise HTTPException(413, "a recording of more than 64 MB is too long for a class")
        path = f"api/recordings/{quote(name)}"
        return await wall.of_each(None, lambda server: server.put(path, content))

    return router


def results_router(wall: Wall, results: Results) -> APIRouter:
    """Return the routes that collect files and grade them."""
    router = APIRouter()

    @router.post("/api/collect", status_code=202)
    async def collect() -> None:
        if wall.folder is None:
            raise HTTPException(409, "the students' folders are not on this machine")
        results.begin(wall.folder, list(wall.names))

    @router.get("/api/results.{kind}")
    async def newest(kind: Literal["csv", "xml"]) -> Response:
        if results.failure:
            raise HTTPException(409, results.failure)
        if results.file is None:  # a proxy would not wait until all are graded
            return Response(status_code=202)
        file = results.file.with_suffix(f".{kind}")
        return FileResponse(file, media_type=f"text/{kind}", filename=file.name)

    return router


async def _order(server: FollowedServer, **order: Any) -> bool:
    return await server.order(**order)
