"""Access control: each request and socket brings a token, or is refused."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from urllib.parse import quote

from starlette._utils import get_route_path
from starlette.datastructures import MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from app.page.access import is_guest
from app.page.language import page
from app.page.token_guesses import Guessing
from app.page.tokens import Role, Tokens
from app.settings.config import FRONTEND

SUBPROTOCOL = "brickpose.token."
"""A websocket's subprotocol of this beginning brings a token: browsers cannot set its headers."""
PAGES = re.compile(r"/|/lens|/field_editor|/learn(/\d+)?|/help(/[\w.]*)?")
"""Where people without a token are asked for it."""
READING = frozenset(["GET", "HEAD", "OPTIONS"])
LOOKING = "/api/view/"
"""What is sent there moves a page's own view, and nothing of the robot's."""
NO_TOKEN = (
    "This robot asks for a token. Open the link that the program printed, or send the header "
    "Authorization: Bearer TOKEN."
)
CODE, WHY = "brickpose.code", "brickpose.why"
"""In a scope: whether it may run code; why it only watches, in words, if no token says so."""
NO_PLACE = "All places for those who only watch are taken."


def may_run_code(scope: Scope) -> bool:
    """Whether a request may have Python run that it brings or names; without tokens, any may."""
    return bool(scope.get(CODE, True))


def role_in(scope: Scope) -> Role:
    """Return what a request may do; without tokens, everything."""
    return Role(scope.get("brickpose.role", Role.DRIVE))


class TokenRequired:
    """Passes requests on that bring a token, and notes in their scope what they may do.

    A token comes in the header, in the address (a link), as a websocket's subprotocol, or in the
    cookie that the answer to a link sets.
    """

    def __init__(
        self,
        app: ASGIApp,
        tokens: Tokens,
        clock: Callable[[], float] = time.monotonic,
        most_watching: int = 1000,
    ) -> None:
        """Guard an application.

        Args:
            app: the application to guard.
            tokens: what a request has to bring.
            clock: gives the time [s].
            most_watching: places for requests and sockets that only watch: others stay free.
        """
        self._app = app
        self._most_watching = most_watching
        self._watching = 0
        self._tokens = tokens
        self._clock = clock
        self._guessing = Guessing()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""
        asked = self._tokens.required or is_guest(scope)
        if scope["type"] not in ("http", "websocket") or not asked:
            await self._app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        refusal, role = self._judge(request)
        if refusal is not None:
            await _refuse(refusal, scope, receive, send)
            return
        if role is Role.WATCH and self._watching >= self._most_watching:
            await _refuse(PlainTextResponse(NO_PLACE, 503), scope, receive, send)
            return
        offered = scope.get("subprotocols", [])
        scope["brickpose.role"] = role
        scope[CODE] = self._tokens.allow_code and role is Role.DRIVE and not is_guest(scope)
        scope["subprotocols"] = [name for name in offered if not name.startswith(SUBPROTOCOL)]
        link = request.query_params.get("token", "")
        allowed = self._tokens.role_of(link)
        cookie = None if allowed is None else _cookie(request, link, allowed)
        self._watching += role is Role.WATCH
        try:
            await self._app(scope, receive, _Sender(cookie, offered, send))
        finally:
            self._watching -= role is Role.WATCH

    def _judge(self, request: HTTPConnection) -> tuple[Response | None, Role]:
        """Return an answer to refuse the request with, if need be; and what it may do."""
        tokens = list(_tokens_of(request))
        role = next((role for t in tokens if (role := self._tokens.role_of(t)) is not None), None)
        if role is None:
            return self._refusal(request, tokens), Role.WATCH
        reads = request.scope.get("method", "GET") in READING
        looks = get_route_path(request.scope).startswith(LOOKING)
        if role is Role.WATCH and not (reads or looks):
            return PlainTextResponse("This token only watches.", 403), role
        return None, role

    def _refusal(self, request: HTTPConnection, tokens: list[str]) -> Response:
        """Refuse a request without a right token; wrong ones make their sender wait."""
        if not tokens:
            return _no_token(request)
        stamp, sender = self._clock(), _sender(request)
        wait = self._guessing.wait(sender, stamp)
        if wait > 0:
            text = f"Too many wrong tokens; try again in {wait:.0f} s."
            return PlainTextResponse(text, 429, {"Retry-After": f"{wait + 1:.0f}"})
        self._guessing.wrong(sender, tokens[0], stamp)
        return _no_token(request)


class _Sender:
    """Sends answers, with the cookie or the subprotocol that belongs to the token."""

    def __init__(self, cookie: str | None, offered: list[str], send: Send) -> None:
        self._cookie = cookie
        self._offered = [name for name in offered if name.startswith(SUBPROTOCOL)]
        self._send = send

    async def __call__(self, message: Message) -> None:
        if message["type"] == "http.response.start" and self._cookie is not None:
            MutableHeaders(scope=message).append("Set-Cookie", self._cookie)
        # A browser gives up a socket of which none of the offered subprotocols is chosen.
        if message["type"] == "websocket.accept" and self._offered:
            message = {**message, "subprotocol": message.get("subprotocol") or self._offered[0]}
        await self._send(message)


def _tokens_of(request: HTTPConnection) -> Iterator[str]:
    """Yield the tokens that a request brings; what is given on purpose comes before the cookie."""
    kind, _, value = request.headers.get("authorization", "").partition(" ")
    if kind.lower() in ("bearer", "token"):
        yield value.strip()
    if "token" in request.query_params:
        yield request.query_params["token"]
    for name in request.scope.get("subprotocols", []):
        if name.startswith(SUBPROTOCOL):
            yield name.removeprefix(SUBPROTOCOL)
    # A guest's browser would send our page's cookie along, which says nothing of the guest.
    if not is_guest(request.scope):
        for role in (Role.DRIVE, Role.WATCH):
            cookie = request.cookies.get(_cookie_name(request, role))
            if cookie is not None:
                yield cookie


def _sender(request: HTTPConnection) -> str:
    """Return who has to wait for a wrong token."""
    address = request.client.host if request.client else ""
    elsewhere = request.headers.get("sec-fetch-site", "none") not in ("same-origin", "none")
    # Any page in a browser may guess: the user of that browser must not have to wait.
    return f"a page at {address}" if elsewhere or is_guest(request.scope) else address


def _cookie_name(request: HTTPConnection, role: Role) -> str:
    # Browsers share cookies among the ports of a host, where other robots may be served. Whoever
    # follows a link to watch keeps the cookie to drive: anybody may send such a link.
    port = (request.scope.get("server") or ("", 0))[1]
    return f"brickpose-{port}-watch" if role is Role.WATCH else f"brickpose-{port}"


def _cookie(request: HTTPConnection, token: str, role: Role) -> str:
    secure = "; Secure" if request.url.scheme in ("https", "wss") else ""
    path = f"{quote(request.scope.get('root_path', ''))}/{secure}"
    return f"{_cookie_name(request, role)}={token}; HttpOnly; SameSite=Strict; Path={path}"


def _no_token(request: HTTPConnection) -> Response:
    headers = {"WWW-Authenticate": 'Bearer realm="BrickPose"', "Cache-Control": "no-store"}
    if PAGES.fullmatch(get_route_path(request.scope)) and "text/html" in request.headers.get(
        "accept", ""
    ):
        return page(FRONTEND / "token.html", request, 401, headers)
    return PlainTextResponse(NO_TOKEN, 401, headers)


async def _refuse(answer: Response, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "http":
        await answer(scope, receive, send)
        return
    socket = WebSocket(scope, receive, send)
    if "websocket.http.response" in scope.get("extensions", {}):
        await socket.send_denial_response(answer)
    else:
        await socket.close(1008, "a token is missing or wrong")
