"""The page's language: by a cookie, which its switch sets, or by what the browser asks for."""

from __future__ import annotations

import gzip
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType

from fastapi import APIRouter, HTTPException
from fastapi.responses import HTMLResponse
from starlette.requests import HTTPConnection

from app.languages.catalogue import ENGLISH, Catalogue, catalogue, languages
from app.languages.markup import translated
from app.messages.answers import LanguageMessage, refusal

COOKIE = "brickpose-language"
NOTHING: Mapping[str, str] = MappingProxyType({})
HEADERS = {"Cache-Control": "no-cache", "Vary": "Accept-Language, Cookie, Accept-Encoding"}


def language_router() -> APIRouter:
    """Return the routes that serve the catalogues."""
    router = APIRouter()

    @router.get("/api/language/{code}.json", responses=refusal(404, "no such language"))
    def texts(code: str) -> LanguageMessage:
        """Return the texts of a language, by their English ones."""
        if code not in languages():
            valid = ", ".join(languages())
            raise HTTPException(404, f"there is no language {code}; valid are {valid}")
        own = catalogue(code)
        return LanguageMessage(
            language=code, plural=own.plural, point=own.point,
            texts={text: list(forms) for text, forms in own.texts.items()},
        )  # fmt: skip

    return router


def page(
    path: Path,
    request: HTTPConnection,
    status: int = 200,
    headers: Mapping[str, str] = NOTHING,
    content: Mapping[str, str] = NOTHING,
) -> HTMLResponse:
    """Return a page of the frontend in the language of a request.

    ``content`` is HTML by name, which is not translated: it stands where ``<!-- name -->`` does.
    """
    own = language_of(request)
    text = _page(path, path.stat().st_mtime_ns, own.language)
    for name, html in content.items():
        text = text.replace(f"<!-- {name} -->", html, 1)
    said = {**HEADERS, "Content-Language": own.language, **headers}
    if "gzip" not in request.headers.get("accept-encoding", ""):
        return HTMLResponse(text, status, said)
    return HTMLResponse(_compressed(text), status, {**said, "Content-Encoding": "gzip"})


def language_of(request: HTTPConnection) -> Catalogue:
    """Return the language that a request asks for: by its cookie, else by Accept-Language."""
    chosen = request.cookies.get(COOKIE)
    wanted = [chosen] if chosen else accepted(request.headers.get("accept-language", ""))
    return catalogue(next((code for code in wanted if code in languages()), ENGLISH))


def accepted(header: str) -> list[str]:
    """Return the languages of an Accept-Language header, the most wanted first, without places.

    >>> accepted("fr;q=0.3, de-AT, en;q=0.7")
    ['de', 'en', 'fr']
    """
    weighed = [_weighed(part) for part in header.split(",")]
    return [code for weight, code in sorted(weighed, key=lambda each: -each[0]) if weight > 0]


def _weighed(part: str) -> tuple[float, str]:
    code, _, quality = part.partition(";")
    try:
        weight = float(quality.strip().removeprefix("q=") or 1)
    except ValueError:
        weight = 0.0
    return weight, code.strip().lower().split("-")[0]


@lru_cache
def _compressed(text: str) -> bytes:
    """Return a page gzipped, a quarter as large; nothing in it is secret."""
    return gzip.compress(text.encode(), mtime=0)


@lru_cache
def _page(path: Path, changed: int, code: str) -> str:
    """Return a page in a language; ``changed`` is when its file was, so that a new one is read."""
    own = catalogue(code)
    text = translated(path.read_text(encoding="utf-8"), own.t)
    return text.replace(
        '<html lang="en">', f'<html lang="{code}" data-languages="{" ".join(languages())}">', 1
    )
