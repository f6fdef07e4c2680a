"""Names who a page's connection belongs to: the pages of one browser are one person's."""

from __future__ import annotations

import re
import secrets
from urllib.parse import quote, unquote

from starlette.requests import HTTPConnection
from starlette.responses import Response

from app.engine.driver import Driver
from app.languages.marking import phrase

NAME = "brickpose-name"
"""The cookie in which a page keeps what its person calls themselves."""
LONGEST_NAME = 30
TAB = re.compile(r"[A-Za-z0-9]{8,64}")
"""What a tab calls itself, for a browser that keeps no cookies."""

LESSON = phrase("the lesson")
THEIR_LESSON = phrase("the lesson of {name}")
PHONE, TABLET, COMPUTER = phrase("a phone"), phrase("a tablet"), phrase("a computer")
THEIR_DEVICE = {
    PHONE: phrase("the phone of {name}"),
    TABLET: phrase("the tablet of {name}"),
    COMPUTER: phrase("the computer of {name}"),
}


def know(request: HTTPConnection, answer: Response) -> None:
    """Let a browser that gets a page keep a number drawn at random, by which it is known again."""
    name = _cookie(request)
    if name not in request.cookies:
        answer.set_cookie(
            name,
            secrets.token_urlsafe(16),
            path=quote(request.scope.get("root_path", "")) + "/",
            httponly=True,
            samesite="strict",
            secure=request.url.scheme == "https",
        )


def driver_of(socket: HTTPConnection) -> Driver:
    """Return the driver that a connection is; those of one browser are one person.

    Without cookies a tab is a person by what it calls itself, and any other program is one for each
    of its connections.
    """
    address = socket.client and socket.client.host
    number = socket.cookies.get(_cookie(socket))
    tab = socket.query_params.get("tab", "")
    if number is None and not TAB.fullmatch(tab):
        return Driver.numbered(phrase("program {number}"), address)
    driver = Driver.at(_words(socket), address)
    # A tab's own name must never be taken for a browser's number.
    driver.person = f"browser {number}" if number else f"tab {tab}"
    return driver


def _words(socket: HTTPConnection) -> str:
    name = _name(socket)
    if socket.query_params.get("page") == "lesson":
        return THEIR_LESSON.format(name=name) if name else LESSON
    device = _device(socket.headers.get("user-agent", ""))
    return THEIR_DEVICE[device].format(name=name) if name else device


def _name(socket: HTTPConnection) -> str:
    """Return what its person wants to be called, in one short line."""
    name = unquote(socket.cookies.get(NAME, ""))
    return " ".join("".join(c for c in name if c.isprintable()).split())[:LONGEST_NAME].strip()


def _device(agent: str) -> str:
    """Return the kind of device by what its browser says of itself."""
    if "iPad" in agent or "Tablet" in agent or ("Android" in agent and "Mobile" not in agent):
        return TABLET
    return PHONE if "Mobi" in agent else COMPUTER


def _cookie(request: HTTPConnection) -> str:
    # Browsers share cookies among the ports of a host, where other robots may be served.
    return f"brickpose-{(request.scope.get('server') or ('', 0))[1]}-person"
