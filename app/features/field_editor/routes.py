"""Routes of fields of one's own: their list, pictures, files, sheets to print, and the editor."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache, partial
from pathlib import Path
from threading import BoundedSemaphore, Lock
from typing import Annotated

import cv2
from fastapi import APIRouter, HTTPException, Query, Request, Response
from fastapi.responses import HTMLResponse, PlainTextResponse
from starlette.concurrency import run_in_threadpool

from app.engine.program import Program
from app.features.field_editor.editable import editable
from app.features.field_editor.messages import (
    EditableDrawingMessage,
    FieldEntry,
    KeptFieldMessage,
)
from app.features.field_editor.sheets import SheetsError, laid_out, sheets_pdf
from app.features.field_editor.shelf import (
    LARGEST_DRAWING,
    LARGEST_PICTURE,
    FieldShelf,
    ShelvedField,
)
from app.foreign_files import read_apart
from app.languages.catalogue import Catalogue, catalogue
from app.messages.answers import content, refusal
from app.page.language import language_of, page
from app.page.shown_floor import shown_floor
from app.settings.config import FRONTEND, MAPS
from robot.errors import BrickPoseError
from robot.fields.drawing.svg_file import read_bytes
from robot.fields.drawing.svg_values import SvgError
from robot.fields.field import FieldError
from robot.fields.field_loading import load_field
from robot.fields.map_files import MAX_YAML_BYTES

NO_FIELD = refusal(404, "no such field, or no drawing") | refusal(503, "too many ask at once")
CHANGE = refusal(409, "a name that is taken, or a file that is no field") | refusal(
    413, "a file that is too large"
)
DRAWING = content("text/plain") | NO_FIELD
PICTURE = content("image/png") | NO_FIELD
SHEETS = content("application/pdf") | NO_FIELD
MOST_WAITING = 4
"""Requests that wait for a file to be read; they hold threads that all others need, too."""
PICTURE_SIDE = 240
"""Longer side of a picture [px]: twice what the page shows, for sharp screens."""
KEPT_PICTURE = {"Cache-Control": "private, max-age=86400"}
"""The page asks with the time at which the file was written."""


def field_editor_router(program: Program) -> APIRouter:
    """List, show, keep, edit and print fields."""
    router = APIRouter()
    shelf = FieldShelf(program.config.mapping.path())

    @router.get("/field_editor", include_in_schema=False)
    def editor(request: Request) -> HTMLResponse:
        return page(FRONTEND / "features" / "field_editor" / "editor.html", request)

    @router.get("/api/field_list")
    def field_list() -> list[FieldEntry]:
        """The fields that the page can load; of generated ones, an example."""
        return [
            FieldEntry(name=each.name, own=each.own, drawing=each.is_drawing, changed=each.changed)
            for each in shelf.listed()
        ]

    _add_views(router, shelf)
    _add_changes(router, shelf)
    return router


def _add_views(router: APIRouter, shelf: FieldShelf) -> None:
    turns = _Turns()

    @router.get("/api/drawings/{name}", response_class=Response, responses=DRAWING)
    def drawing(name: str) -> Response:
        """A field's drawing. It is sent as text, so that no browser runs what may be in it."""
        with _refused(404):
            file = _drawing(shelf.find(name))
            return PlainTextResponse(read_bytes(file), headers=KEPT_PICTURE)

    @router.get("/api/drawings/{name}/picture.png", response_class=Response, responses=PICTURE)
    def picture(name: str) -> Response:
        """A small picture of a field that is listed, from above."""
        with _refused(404):
            shelved = next((each for each in shelf.listed() if each.name == name), None)
            if shelved is None:
                raise FieldError(f"there is no picture of the field {name!r}")
            with turns.taken():
                png = _picture(str(shelved.file or shelved.name), shelved.changed)
        return Response(png, media_type="image/png", headers=KEPT_PICTURE)

    @router.get("/api/drawings/{name}/strokes", responses=NO_FIELD)
    def strokes(name: str) -> EditableDrawingMessage:
        """A drawing as the editor takes it: strips of tape as lines and arcs."""
        with _refused(404), turns.taken():
            return read_apart(editable, _drawing(shelf.find(name)))

    @router.get("/api/drawings/{name}/sheets.pdf", response_class=Response, responses=SHEETS)
    def sheets(
        request: Request,
        name: str,
        paper: str = "a4",
        overlap: Annotated[float, Query(allow_inf_nan=False)] = 10.0,
    ) -> Response:
        """A drawing at its true size over several sheets, with marks to glue; overlap in mm."""
        language = language_of(request).language
        with _refused(404), turns.taken():
            file = _drawing(shelf.find(name))
            printed = read_apart(
                partial(_sheets, name=name, paper=paper, overlap=overlap, language=language), file
            )
        return Response(printed, media_type="application/pdf")


def _add_changes(router: APIRouter, shelf: FieldShelf) -> None:
    @router.put("/api/drawings/{name}", responses=CHANGE)
    async def keep(
        request: Request,
        name: str,
        yaml_bytes: Annotated[int, Query(ge=0, le=MAX_YAML_BYTES)] = 0,
        replace: bool = False,
    ) -> KeptFieldMessage:
        """Keep a field: the body is a drawing, or a ROS map's YAML and its picture behind it."""
        with _refused(409):
            limit = LARGEST_PICTURE + yaml_bytes if yaml_bytes else LARGEST_DRAWING
            body = await _bounded(request, limit)
            work = partial(shelf.keep, name, body, yaml_bytes=yaml_bytes, replace=replace)
            remark = await run_in_threadpool(work)
        return KeptFieldMessage(name=name, remarks=[remark] if remark else [])

    @router.delete("/api/drawings/{name}", status_code=204, responses=CHANGE)
    def delete(name: str) -> None:
        """Delete a field of the user's."""
        with _refused(409):
            shelf.delete(name)


async def _bounded(request: Request, limit: int) -> bytes:
    """Return a request's body.

    Raises:
        HTTPException: it is longer than the limit [bytes]; no more than that is kept.
    """
    body = bytearray()
    announced = request.headers.get("content-length", "0")
    if announced.isdecimal() and int(announced) <= limit:
        async for block in request.stream():
            body += block
            if len(body) > limit:
                break
        else:
            return bytes(body)
    raise HTTPException(413, f"the file is too large; valid are up to {limit >> 20} MB")


def _drawing(field: ShelvedField) -> Path:
    if field.file is None or not field.is_drawing:
        raise FieldError(f"the field {field.name} is no drawing; valid is one that is an SVG")
    return field.file


@lru_cache(maxsize=64)
def _picture(name: str, _changed: float) -> bytes:
    """Return the picture of a field by its name or file; made again when the file has changed."""
    # A file of somebody else's costs the robot nothing.
    return read_apart(_drawn, Path(name)) if Path(name).suffix else _drawn(Path(name))


def _drawn(name: Path) -> bytes:
    floor = shown_floor(load_field(str(name), MAPS))
    shrink = min(1.0, PICTURE_SIDE / max(floor.shape))
    small = cv2.resize(floor, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    _, png = cv2.imencode(".png", small)
    return png.tobytes()


def _sheets(file: Path, name: str, paper: str, overlap: float, language: str) -> bytes:
    own: Catalogue = catalogue(language)
    try:
        return sheets_pdf(laid_out(read_bytes(file), paper, overlap), name, own)
    except SvgError as error:
        raise SheetsError(f"{name}: {error}") from error


class _Turns:
    """Lets files be read one at a time: each costs a process, and who only watches may ask, too."""

    def __init__(self) -> None:
        self._waiting = BoundedSemaphore(MOST_WAITING)
        self._reading = Lock()

    @contextmanager
    def taken(self) -> Iterator[None]:
        """Wait for a turn.

        Raises:
            HTTPException: too many wait already.
        """
        if not self._waiting.acquire(blocking=False):
            raise HTTPException(503, "too many drawings are asked for; try again in a moment")
        try:
            with self._reading:
                yield
        finally:
            self._waiting.release()


@contextmanager
def _refused(status: int) -> Iterator[None]:
    try:
        yield
    except BrickPoseError as error:
        raise HTTPException(status, str(error)) from error
