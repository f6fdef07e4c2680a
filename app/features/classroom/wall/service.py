"""The wall's server: a page for the teacher, and what its buttons do. The hub starts it."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial
from typing import Annotated, Any
from urllib.parse import unquote, urlsplit

import anyio
import uvicorn
from fastapi import FastAPI, HTTPException, Response
from fastapi.responses import FileResponse
from pydantic import BaseModel, ConfigDict, Field
from starlette.staticfiles import StaticFiles

from app.features.classroom.class_desk import LONGEST_MESSAGE
from app.features.classroom.hub_client import HubClient, HubEnvironment
from app.features.classroom.sign_in import Sessions, SignIn
from app.features.classroom.wall.collecting import Results
from app.features.classroom.wall.followed import FollowedServer
from app.features.classroom.wall.wall import Wall, class_folder_of
from app.features.reverse_proxy.below_path import BelowPath
from app.page.access import SameOriginOnly
from app.settings.config import FRONTEND

PAGE = FRONTEND / "features" / "classroom" / "wall"


class _Asked(BaseModel):
    model_config = ConfigDict(extra="forbid")
    who: list[str] | None = None
    """Logins; none is all."""


class Freeze(_Asked):
    """Freezes robots, or lets them go on."""

    frozen: bool


class Say(_Asked):
    """A message to students' pages; empty takes it away."""

    text: Annotated[str, Field(max_length=LONGEST_MESSAGE)]


class Place(_Asked):
    """Puts simulated robots at one place, and tells them so: x, y [m], theta [rad]."""

    x: Annotated[float, Field(allow_inf_nan=False, ge=-100, le=100)]
    y: Annotated[float, Field(allow_inf_nan=False, ge=-100, le=100)]
    theta: Annotated[float, Field(allow_inf_nan=False, ge=-7, le=7)]


class UseField(_Asked):
    """Hands out a field."""

    name: Annotated[str, Field(min_length=1, max_length=100)]


def wall_app(wall: Wall, hub: HubClient) -> FastAPI:
    """Return the application of a wall, behind the hub's sign-in."""

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(wall.run)
            app.state.results = Results(tasks)
            yield
            tasks.cancel_scope.cancel()

    app = FastAPI(title="BrickPose: wall", lifespan=lifespan, docs_url=None, redoc_url=None)

    @app.get("/")
    def page() -> FileResponse:
        return FileResponse(PAGE / "wall.html", headers={"Cache-Control": "no-cache"})

    @app.get("/api/tiles")
    def tiles() -> list[dict[str, Any]]:
        return wall.tiles()

    @app.get("/api/floor/{login}.png")
    async def floor(login: str) -> Response:
        picture = await wall.picture(login)
        if picture is None:
            raise HTTPException(404, f"{login} has no field now")
        return Response(picture, media_type="image/png")

    @app.post("/api/freeze")
    async def freeze(asked: Freeze) -> dict[str, Any]:
        return await wall.of_each(asked.who, partial(_order, frozen=asked.frozen))

    @app.post("/api/message")
    async def message(asked: Say) -> dict[str, Any]:
        return await wall.of_each(asked.who, partial(_order, message=asked.text))

    @app.post("/api/place")
    async def place(asked: Place) -> dict[str, Any]:
        pose = {"x": asked.x, "y": asked.y, "theta": asked.theta}

        async def put(server: FollowedServer) -> bool:
            await server.send(type="stop")
            placed = await server.send(type="place", **pose)
            return placed and await server.send(type="set_pose", **pose)

        return await wall.of_each(asked.who, put)

    @app.post("/api/field")
    async def use_field(asked: UseField) -> dict[str, Any]:
        async def change(server: FollowedServer) -> bool:
            return await server.send(type="use_field", name=asked.name)

        return await wall.of_each(asked.who, change)

    @app.post("/api/start")
    async def start() -> dict[str, int]:
        return {"started": await wall.start_all()}

    @app.post("/api/collect", status_code=202)
    async def collect() -> None:
        if wall.folder is None:
            raise HTTPException(409, "the students' folders are not on this machine")
        app.state.results.begin(wall.folder, list(wall.names))

    @app.get("/api/results.csv")
    async def results() -> Response:
        if app.state.results.failure:
            raise HTTPException(409, app.state.results.failure)
        if app.state.results.file is None:  # a proxy would not wait until all are graded
            return Response(status_code=202)
        return FileResponse(app.state.results.file, media_type="text/csv", filename="results.csv")

    app.mount("/static", StaticFiles(directory=PAGE), name="static")
    app.add_middleware(SameOriginOnly, names=frozenset({"localhost"}))
    app.add_middleware(SignIn, hub=hub, sessions=Sessions())
    app.add_middleware(BelowPath, root=unquote(hub.environment.prefix).rstrip("/"))
    return app


async def _order(server: FollowedServer, **order: Any) -> bool:
    return await server.order(**order)


def main() -> None:
    """Serve the wall as the hub's environment says, until a signal."""
    own = HubEnvironment.of(os.environ)
    hub, place = HubClient(own), urlsplit(own.service_url)
    base = own.base_url.rstrip("/")
    address = os.environ["BRICKPOSE_PROXY_ADDRESS"].rstrip("/").removesuffix(base)
    wall = Wall(hub, address, class_folder_of(os.environ))
    uvicorn.run(
        wall_app(wall, hub), host=place.hostname or "127.0.0.1", port=place.port or 8004,
        log_level="warning", proxy_headers=False, timeout_graceful_shutdown=1,
    )  # fmt: skip


if __name__ == "__main__":
    main()
