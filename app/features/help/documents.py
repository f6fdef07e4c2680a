"""The routes of ``/help``: each document by its file's name, so that their own links hold."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from html import escape
from pathlib import Path

from fastapi import APIRouter, HTTPException, Request
from fastapi.responses import FileResponse, HTMLResponse, RedirectResponse

from app.engine.plugging import plugged
from app.engine.program import Program
from app.features.help.markdown import rendered, title_of
from app.page.language import page
from app.settings.config import DOCS, FRONTEND

FRAME = FRONTEND / "features" / "help" / "documents.html"
FIRST = "page.md"
"""What ``/help/`` shows: how the page is used."""


def documents_router(program: Program) -> APIRouter:
    """Return the routes that serve the documents, those of other features too, and pictures."""
    router, more = APIRouter(include_in_schema=False), plugged().features.documents

    @router.get("/help")
    def without_slash() -> RedirectResponse:
        # Links of a document begin at its folder.
        return RedirectResponse("help/")

    @router.get("/help/")
    def first(request: Request) -> HTMLResponse:
        return _shown(FIRST, more, request)

    @router.get("/help/{name}")
    def document(name: str, request: Request) -> HTMLResponse:
        return _shown(name, more, request)

    @router.get("/help/pictures/{name}")
    def picture(name: str) -> FileResponse:
        known = {path.name: path for path in (DOCS / "pictures").glob("*.png")}
        if name not in known:
            raise HTTPException(404, f"there is no picture {name}")
        return FileResponse(known[name], headers={"Cache-Control": "no-cache"})

    return router


def _shown(name: str, more: Sequence[Path], request: Request) -> HTMLResponse:
    known = {path.name: path for path in sorted(DOCS.glob("*.md"))}
    known |= {path.name: path for path in more if path.name not in known and path.is_file()}
    if name not in known:
        raise HTTPException(404, f"there is no document {name}; valid are {', '.join(known)}")
    title, text = _read(known[name], known[name].stat().st_mtime_ns)
    titles = {each: _read(path, path.stat().st_mtime_ns)[0] for each, path in known.items()}
    return page(
        FRAME, request, content={"title": escape(title), "list": _list(titles, name), "text": text}
    )


def _list(titles: dict[str, str], shown: str) -> str:
    return "".join(
        f'<li><a href="{escape(name)}"{" aria-current=page" if name == shown else ""}>'
        f"{escape(title)}</a></li>"
        for name, title in titles.items()
    )


@lru_cache(maxsize=64)
def _read(path: Path, changed: int) -> tuple[str, str]:
    """Return title and HTML; ``changed`` is when the file was, so that a new one is read."""
    text = path.read_text(encoding="utf-8")
    return title_of(text), rendered(text)
