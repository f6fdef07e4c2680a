"""The web application: page, telemetry, commands, pictures and 3D view on one port."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
from fastapi import APIRouter, FastAPI, HTTPException, Request, Response, WebSocket
from fastapi.responses import FileResponse, HTMLResponse
from starlette.datastructures import Headers
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from app.engine.engine_thread import EngineThread
from app.engine.program import Program
from app.engine.start_pose.keeping import PoseKeeper
from app.messages.answers import (
    AccessMessage,
    content,
    refusal,
)
from app.page.access import SameOriginOnly, own_names
from app.page.calibration import calibration_router
from app.page.camera_stream import STREAM, CameraStream
from app.page.docs_page import docs_page
from app.page.documents.routes import documents_router
from app.page.faults import faults_router
from app.page.field import NO_PICTURE, field_router
from app.page.filter_by_hand import hand_router
from app.page.floor_grid import floor_grid_router
from app.page.language import language_router, page
from app.page.lens.routes import lens_router
from app.page.mapping import mapping_router, sketch_of
from app.page.outlets import Outlets
from app.page.state import state_router
from app.page.token_guard import TokenRequired, role_in
from app.page.tokens import Role, Tokens
from app.page.view.cameras import Look
from app.page.view.view import View
from app.page.weighing import weighing_router
from app.recordings.contents import contents_of
from app.recordings.replay.recorded_robot import replayed
from app.recordings.routes import contents_router, recordings_router
from app.ros2.websocket_routes import Foxglove, Rosbridge
from app.settings.config import FRONTEND

FOXGLOVE = "/foxglove"


def create_app(
    program: Program,
    thread: EngineThread,
    outlets: Outlets,
    tokens: Tokens | None = None,
    routers: Sequence[APIRouter] = (),
) -> FastAPI:
    """Make the application of a program; the engine's thread runs as long as the application.

    With tokens, each request must bring one of them. Routers of other rooms are served as well.
    """
    view = View(
        program.field, program.robot.spec, program.engine.latest, lambda: sketch_of(outlets.mapping)
    )
    keeper = PoseKeeper(
        program.pose_file,
        program.config.start_pose.save_pose_rate,
        program.field,
        program.engine.latest,
    )

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        thread.start()
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(view.follow)
                tasks.start_soon(keeper.follow)
                yield
                tasks.cancel_scope.cancel()
        finally:
            thread.stop()
            keeper.save()
            view.close()

    # FastAPI's own documentation page fetches its scripts from the internet.
    app = FastAPI(title="BrickPose", lifespan=lifespan, docs_url=None, redoc_url=None)
    config = program.config
    inviting = frozenset([FOXGLOVE] if config.ros2.foxglove and tokens is not None else [])
    if tokens is not None:
        app.add_middleware(TokenRequired, tokens=tokens)
    # Added last, so it comes first: pages of other sites learn nothing of tokens.
    names, origins = own_names(config.host), config.allowed_origins
    app.add_middleware(SameOriginOnly, names=names, origins=origins, inviting=inviting)
    _add_page(app)
    camera = CameraStream(program.engine.latest, thread.stopping)
    _add_streams(app, view, camera)
    _add_rosbridge(app, outlets.rosbridge)
    if config.ros2.foxglove:
        _add_foxglove(app, outlets.foxglove)
    app.include_router(language_router())
    app.include_router(documents_router())
    app.include_router(state_router(program, thread, (view, keeper), outlets))
    app.include_router(field_router(program))
    app.include_router(floor_grid_router(program))
    app.include_router(lens_router(program))
    app.include_router(calibration_router(program, outlets.calibrator))
    app.include_router(mapping_router(outlets.mapping))
    app.include_router(faults_router(program))
    app.include_router(weighing_router(program))
    app.include_router(hand_router(program))
    app.include_router(recordings_router(program.config.recording.path, replayed(program.robot)))
    app.include_router(contents_router(lambda: contents_of(program)))
    for router in routers:
        app.include_router(router)
    return app


def _add_page(app: FastAPI) -> None:
    @app.get("/", include_in_schema=False)
    def index(request: Request) -> HTMLResponse:
        return page(FRONTEND / "index.html", request)

    @app.get("/api/access")
    def access(request: Request) -> AccessMessage:
        """What this request's token allows; 401 without one."""
        return AccessMessage.model_validate({"role": role_in(request.scope).value})

    @app.get("/docs", include_in_schema=False)
    def docs() -> HTMLResponse:
        return HTMLResponse(docs_page(app.openapi()))

    app.mount("/static", _Revalidated(directory=FRONTEND), name="static")


class _Revalidated(StaticFiles):
    """Files that a browser caches but checks each time, so that a new version shows at once."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        """Answer with a file; the page itself is served at ``/`` alone."""
        if path == "index.html":
            raise HTTPException(404)
        return await super().get_response(path, scope)

    def file_response(
        self,
        full_path: str | os.PathLike[str],
        stat_result: os.stat_result,
        scope: Scope,
        status_code: int = 200,
    ) -> Response:
        response: Response = super().file_response(full_path, stat_result, scope, status_code)
        response.headers["Cache-Control"] = "no-cache"
        part = scope["method"] != "GET" or "range" in Headers(scope=scope)
        if not isinstance(response, FileResponse) or part:
            return response
        # Our files are small: reading one in another thread takes longer than reading it here.
        del response.headers["content-length"]
        return Response(Path(full_path).read_bytes(), status_code, response.headers)


def _add_streams(app: FastAPI, view: View, camera: CameraStream) -> None:
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
    def view_page(request: Request) -> Response:
        return view.page(request)

    @app.get("/view/{page}/", include_in_schema=False)
    def view_page_of(page: str, request: Request) -> Response:
        return view.page(request)

    @app.post("/api/view/{page}/{look}", status_code=204, responses=refusal(404, "no such viewer"))
    def look_at_view(page: str, look: Look) -> None:
        """Move the camera of a page's 3D view: home, above the field, or behind the robot."""
        if not view.cameras.look(page, look):
            raise HTTPException(404, "The 3D view is not there yet.")

    @app.websocket("/view")
    @app.websocket("/view/{page}")
    async def follow_view(socket: WebSocket) -> None:
        await view.serve(socket)


def _add_rosbridge(app: FastAPI, rosbridge: Rosbridge) -> None:
    # roslibpy's Ros(host, port) takes no path.
    @app.websocket("/")
    @app.websocket("/rosbridge")
    async def follow_topics(socket: WebSocket) -> None:
        await rosbridge.serve(socket, watches=role_in(socket.scope) is Role.WATCH)


def _add_foxglove(app: FastAPI, foxglove: Foxglove) -> None:
    @app.websocket(FOXGLOVE)
    async def follow_viewer(socket: WebSocket) -> None:
        await foxglove.serve(socket, watches=role_in(socket.scope) is Role.WATCH)
