"""Routes of the wall: what it shows, orders and collects."""

from __future__ import annotations

from functools import partial
from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Response
from fastapi.responses import FileResponse
from pydantic import BaseModel, ConfigDict, Field

from app.features.classroom.class_desk import LONGEST_MESSAGE
from app.features.classroom.wall.collecting import Results
from app.features.classroom.wall.followed import FollowedServer
from app.features.classroom.wall.wall import Wall
from app.settings.config import FRONTEND

PAGE = FRONTEND / "features" / "classroom" / "wall"


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


class UseField(_Asked):
    """Hands out a field."""

    name: Annotated[str, Field(min_length=1, max_length=100)]


def shown_router(wall: Wall) -> APIRouter:
    """Return the routes of the page and of what it shows."""
    router = APIRouter()

    @router.get("/")
    def page() -> FileResponse:
        return FileResponse(PAGE / "wall.html", headers={"Cache-Control": "no-cache"})

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

        async def put(server: FollowedServer) -> bool:
            await server.send(type="stop")
            placed = await server.send(type="place", **pose)
            return placed and await server.send(type="set_pose", **pose)

        return await wall.of_each(asked.logins, put)

    @router.post("/api/field")
    async def use_field(asked: UseField) -> dict[str, Any]:
        async def change(server: FollowedServer) -> bool:
            return await server.send(type="use_field", name=asked.name)

        return await wall.of_each(asked.logins, change)

    @router.post("/api/start")
    async def start() -> dict[str, int]:
        return {"started": await wall.start_all()}

    return router


def results_router(wall: Wall, results: Results) -> APIRouter:
    """Return the routes that collect files and grade them."""
    router = APIRouter()

    @router.post("/api/collect", status_code=202)
    async def collect() -> None:
        if wall.folder is None:
            raise HTTPException(409, "the students' folders are not on this machine")
        results.begin(wall.folder, list(wall.names))

    @router.get("/api/results.csv")
    async def newest() -> Response:
        if results.failure:
            raise HTTPException(409, results.failure)
        if results.file is None:  # a proxy would not wait until all are graded
            return Response(status_code=202)
        return FileResponse(results.file, media_type="text/csv", filename="results.csv")

    return router


async def _order(server: FollowedServer, **order: Any) -> bool:
    return await server.order(**order)
