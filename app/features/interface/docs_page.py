"""``/docs``: the interface as one plain page, made here, so that it works without internet."""

from __future__ import annotations

import json
from collections.abc import Iterator
from html import escape
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

from app.engine.plugging import plugged
from app.engine.program import Program
from app.messages.schema import schema

STYLE = (
    ":root{color-scheme:light dark;font:16px/1.5 system-ui,sans-serif}"
    "body{max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse;width:100%}"
    "th,td{text-align:left;vertical-align:top;padding:.3rem .8rem .3rem 0;"
    "border-bottom:1px solid #8884}"
)


def docs_router(program: Program) -> APIRouter:
    """Return the route of the page; it describes whatever the application has."""
    router = APIRouter(include_in_schema=False)

    @router.get("/docs")
    def docs(request: Request) -> HTMLResponse:
        return HTMLResponse(docs_page(request.app.openapi()))

    return router


def docs_page(openapi: dict[str, Any]) -> str:
    """Return the page: addresses from the OpenAPI description, and all messages with fields."""
    title = escape(str(openapi["info"]["title"]))
    parts = [
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}: interface</title>',
        '<meta name="viewport" content="width=device-width">',
        f"<style>{STYLE}</style><h1>{title}: interface</h1>",
        '<p>Over HTTP, described for programs in <a href="openapi.json">/openapi.json</a>:</p>',
        _table(("address", "is"), _addresses(openapi)),
        "<p>The WebSocket <code>/api/live</code> sends Telemetry as JSON text and takes the "
        "commands below; each is answered by an Ack or an Error with the same id. Metres, seconds "
        "and radians, in the map frame; theta from +x, anticlockwise.</p>",
        "<p>The WebSocket <code>/api/camera</code> sends each picture with its scan, as "
        '<a href="#PictureMessage">PictureMessage</a> describes.</p>',
        *(_message(name, model) for name, model in schema(plugged().all_messages).items()),
    ]
    return "\n".join(parts)


def _addresses(openapi: dict[str, Any]) -> Iterator[tuple[str, str]]:
    for path, methods in openapi["paths"].items():
        for method, about in methods.items():
            meaning = about.get("description", about["summary"])
            yield f"<code>{method.upper()} {escape(path)}</code>", escape(meaning)


def _message(name: str, model: dict[str, Any]) -> str:
    needed = model.get("required", ())
    rows = [
        (
            f"<code>{escape(key)}</code>{'' if key in needed else ' (optional)'}",
            escape(_kind(about)),
            escape(about.get("description", "")),
        )
        for key, about in model.get("properties", {}).items()
    ]
    table = _table(("key", "is", "meaning"), rows)
    about = escape(model.get("description", ""))
    return f'<h2 id="{escape(name)}">{escape(name)}</h2>\n<p>{about}</p>\n{table}'


def _kind(about: dict[str, Any]) -> str:
    """Return a JSON schema in words."""
    if "$ref" in about:
        return str(about["$ref"]).rpartition("/")[2]
    if "const" in about or "enum" in about:
        return " or ".join(json.dumps(value) for value in about.get("enum", [about.get("const")]))
    if "anyOf" in about:
        return " or ".join(_kind(each) for each in about["anyOf"])
    if about.get("type") == "array":
        if "prefixItems" in about:
            return f"({', '.join(_kind(item) for item in about['prefixItems'])})"
        return f"list of {_size(about)}{_kind(about.get('items', {}))}"
    low, high = (
        about.get(inclusive, about.get(exclusive))
        for inclusive, exclusive in (
            ("minimum", "exclusiveMinimum"),
            ("maximum", "exclusiveMaximum"),
        )
    )
    kind = str(about.get("type", "value"))
    return kind if low is None or high is None else f"{kind}, {low:g} to {high:g}"


def _size(about: dict[str, Any]) -> str:
    low, high = about.get("minItems"), about.get("maxItems")
    if high is None:
        return ""
    return f"{high} x " if low == high else f"{low or 0} to {high} x "


def _table(heads: tuple[str, ...], rows: Any) -> str:
    head = "".join(f"<th>{each}</th>" for each in heads)
    body = "\n".join("<tr>" + "".join(f"<td>{item}</td>" for item in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>\n{body}</table>"
