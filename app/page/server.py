"""Creates the server's web application: page, telemetry, commands, pictures, 3D view."""

from __future__ import annotations

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import anyio
from fastapi import APIRouter, FastAPI, HTTPException, Request, Response, WebSocket
from fastapi.responses import JSONResponse

from app.engine.engine_thread import EngineThread
from app.engine.program import Program
from app.engine.rest import Audience
from app.messages.answers import ViewCameraMessage, content, refusal
from app.page.application import new_application
from app.page.camera_stream import STREAM, CameraStream
from app.page.field import field_router
from app.page.outlets import Outlets
from app.page.state import state_router
from app.page.tokens import Tokens
from app.page.view.cameras import Look
from app.page.view.view import UPDATES_HZ, View

NO_PICTURE = refusal(503, "before the camera's first picture")


def create_app(
    program: Program,
    thread: EngineThread,
    outlets: Outlets,
    tokens: Tokens | None = None,
    routers: Sequence[APIRouter] = (),
) -> FastAPI:
    """Make the application of a program; the engine's thread runs as long as the application.

    With tokens, each request must bring one of them. Routers are those of features.
    """
    view = View(program.field, program.robot.spec, program.engine.latest, outlets.view_layers())

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        thread.start()
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(view.follow)
                yield
                tasks.cancel_scope.cancel()
        finally:
            thread.stop()
            view.close()

    app = new_application(program.config, tokens, lifespan)
    camera = CameraStream(program.engine.latest, thread.stopping, program.engine.audience)
    _add_streams(app, view, camera, program.engine.audience)
    app.include_router(state_router(program, thread, view, outlets))
    app.include_router(field_router(program))
    for router in (*outlets.routers(), *routers):
        app.include_router(router)

    @app.exception_handler(Exception)
    def failed(request: Request, error: Exception) -> Response:
        path = getattr(request.scope.get("route"), "path", request.url.path)
        return JSONResponse({"detail": outlets.note_route(path, error)}, 500)

    return app


def _add_streams(app: FastAPI, view: View, camera: CameraStream, audience: Audience) -> None:
    @app.get("/camera.jpg", response_class=Response, responses=NO_PICTURE | content("image/jpeg"))
    async def picture() -> Response:
        """One picture of the robot's camera."""
        return await camera.picture()

    @app.get("/camera.mjpg", response_class=Response, responses=content(STREAM))
    async def motion_jpeg() -> Response:
        """The robot's camera, live."""
        return camera.motion_jpeg()

    @app.websocket("/api/camera")
    async def follow_camera(socket: WebSocket) -> None:
        await camera.serve(socket)

    @app.get("/view/", include_in_schema=False)
    @app.get("/view/{page}/", include_in_schema=False)
    def view_page(request: Request) -> Response:
        return view.page(request)

    @app.post("/api/view/{page}/{look}", responses=refusal(404, "no such viewer"))
    def look_at_view(page: str, look: Look) -> ViewCameraMessage:
        """Move the camera of a page's 3D view: home, above the field, behind the robot, or not."""
        if (camera := view.cameras.look(page, look)) is None:
            raise HTTPException(404, "The 3D view is not there yet.")
        return camera

    @app.websocket("/view")
    @app.websocket("/view/{page}")
    async def follow_view(socket: WebSocket) -> None:
        with audience.joined(UPDATES_HZ):
            await view.serve(socket)
