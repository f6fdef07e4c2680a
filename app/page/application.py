"""What the web application has with a robot and before there is one: guard and page."""

from __future__ import annotations

import gzip
import mimetypes
import os
from collections.abc import Callable
from contextlib import AbstractAsyncContextManager
from functools import lru_cache
from pathlib import Path

from fastapi import FastAPI, HTTPException, Request, Response
from fastapi.responses import FileResponse, HTMLResponse
from starlette.datastructures import Headers
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from app.engine.plugging import plugged
from app.messages.answers import AccessMessage
from app.page.access import SameOriginOnly, own_names
from app.page.language import language_router, page
from app.page.listening import most_places
from app.page.panels import PANELS, sections_of
from app.page.people import know
from app.page.room import places_to_watch
from app.page.token_guard import WHY, TokenRequired, role_in
from app.page.tokens import Tokens
from app.settings.config import FRONTEND, Config

COMPRESSED = ("text/", "image/svg+xml")
"""Types of files that get a third as large by compression."""

Lifespan = Callable[[FastAPI], AbstractAsyncContextManager[None]]


def new_application(
    config: Config,
    tokens: Tokens | None,
    lifespan: Lifespan | None = None,
) -> FastAPI:
    """Make an application with the page, for those who may see them.

    Args:
        config: says who may reach the program.
        tokens: each request must bring one of them, if there are any.
        lifespan: what runs as long as the application.
    """
    # FastAPI's own documentation page fetches its scripts from the internet.
    app = FastAPI(title="BrickPose", lifespan=lifespan, docs_url=None, redoc_url=None)
    inviting = frozenset[str]()
    if tokens is not None:
        inviting = frozenset(guest.path for guest in plugged().features.guests(config))
        places = places_to_watch(most_places())
        app.add_middleware(TokenRequired, tokens=tokens, most_watching=places)
    # Added last, so it comes first: pages of other sites learn nothing of tokens.
    names, origins = own_names(config.host), config.allowed_origins
    app.add_middleware(SameOriginOnly, names=names, origins=origins, inviting=inviting)
    _add_page(app)
    for gate in plugged().features.gates(config):
        app.add_middleware(gate)
    return app


def _add_page(app: FastAPI) -> None:
    panels = plugged().features.panels

    @app.get("/", include_in_schema=False)
    def index(request: Request) -> HTMLResponse:
        answer = page(FRONTEND / "index.html", request, content={"panels": sections_of(panels)})
        know(request, answer)
        return answer

    @app.get("/api/access")
    def access(request: Request) -> AccessMessage:
        """What this request's token allows; 401 without one."""
        words = {"role": role_in(request.scope).value, "why": request.scope.get(WHY, "")}
        return AccessMessage.model_validate(words)

    # Windows asks its registry, where any program may have said that scripts are plain text; a
    # browser would not run them.
    mimetypes.add_type("text/javascript", ".js")
    app.mount("/static", _Revalidated(directory=FRONTEND), name="static")
    for feature, each in panels.items():
        for panel in each:
            folder = _Revalidated(directory=panel.script.parent)
            app.mount(f"/{PANELS}/{feature}/{panel.name}", folder, name=f"panel {panel.name}")
    app.include_router(language_router())


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
        if not str(response.media_type).startswith(COMPRESSED):
            return Response(Path(full_path).read_bytes(), status_code, response.headers)
        response.headers["Vary"] = "Accept-Encoding"
        if "gzip" not in Headers(scope=scope).get("accept-encoding", ""):
            return Response(Path(full_path).read_bytes(), status_code, response.headers)
        response.headers["Content-Encoding"] = "gzip"
        # A weak tag: a part of the file, by its strong tag, is not a part of these bytes.
        response.headers["ETag"] = f"W/{response.headers['ETag']}"
        body = _compressed(Path(full_path), stat_result.st_mtime_ns)
        return Response(body, status_code, response.headers)


@lru_cache(maxsize=512)
def _compressed(path: Path, _modified_ns: int) -> bytes:
    """Return a file's gzipped content; it is compressed again when the file has changed."""
    return gzip.compress(path.read_bytes(), mtime=0)
