"""The wall's server: a page for the teacher, and what its buttons do. The hub starts it."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from urllib.parse import unquote, urlsplit

import anyio
import uvicorn
from fastapi import FastAPI
from starlette.staticfiles import StaticFiles

from app.features.classroom.hub_client import HubClient, HubEnvironment
from app.features.classroom.sign_in import Sessions, SignIn
from app.features.classroom.wall.collecting import Results
from app.features.classroom.wall.exporting import export_router
from app.features.classroom.wall.routes import (
    handouts_router,
    orders_router,
    results_router,
    shown_router,
)
from app.features.classroom.wall.wall import Wall, class_folder_of
from app.features.reverse_proxy.below_path import BelowPath
from app.page.access import SameOriginOnly
from app.page.language import language_router
from app.settings.config import FRONTEND


def wall_app(wall: Wall, hub: HubClient) -> FastAPI:
    """Return the application of a wall, behind the hub's sign-in."""

    results = Results()

    @asynccontextmanager
    async def lifespan(_app: FastAPI) -> AsyncIterator[None]:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(wall.run)
            results.tasks = tasks
            yield
            tasks.cancel_scope.cancel()

    app = FastAPI(title="BrickPose: wall", lifespan=lifespan, docs_url=None, redoc_url=None)

    own = (shown_router(wall), orders_router(wall), handouts_router(wall))
    routers = (*own, results_router(wall, results), export_router(wall))
    for router in (*routers, language_router()):
        app.include_router(router)
    app.mount("/static", StaticFiles(directory=FRONTEND), name="static")
    app.add_middleware(SameOriginOnly, names=frozenset({"localhost"}))
    app.add_middleware(SignIn, hub=hub, sessions=Sessions())
    app.add_middleware(BelowPath, root=unquote(hub.environment.prefix).rstrip("/"))
    return app


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
