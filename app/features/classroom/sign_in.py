"""SignIn: before a server that a hub has started, visitors sign in at the hub, by OAuth 2.

The flow is RFC 6749's code grant with PKCE (RFC 7636), as the hub offers it. It is done here, and
not by JupyterHub's own classes, because those are made for Tornado's handlers: an environment in
which students' servers run needs no JupyterHub.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from urllib.parse import quote, urlencode

import anyio.to_thread
from starlette.datastructures import Headers
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose

from app.features.classroom.hub_client import HubClient, HubError, Visitor
from app.features.reverse_proxy.own_name import under_own_name

SESSION, STATE = "brickpose-hub", "brickpose-hub-state"
CHECK_S = 60.0
"""A visitor is asked for at the hub again after this time [s]: as long as a sign-out takes to be
heard. At half of it a class of thirty asks its hub once a second."""
SIGN_IN_S = 600.0
MOST = 1000
VISITOR = "brickpose.visitor"
"""In a request's scope: the ``Visitor``."""


@dataclass
class _Session:
    token: str
    visitor: Visitor
    checked: float


@dataclass
class _Attempt:
    next: str
    verifier: str
    begun: float


@dataclass
class Sessions:
    """Who has signed in, and who is about to; in memory, because a new sign-in needs no click."""

    clock: Callable[[], float] = time.monotonic
    known: dict[str, _Session] = field(default_factory=dict)
    attempts: dict[str, _Attempt] = field(default_factory=dict)

    def begin(self, following: str) -> tuple[str, str]:
        """Note a sign-in that begins; return its state and the challenge of its verifier."""
        stamp = self.clock()
        self.attempts = {
            state: each
            for state, each in list(self.attempts.items())[-MOST:]
            if stamp - each.begun < SIGN_IN_S
        }
        state, verifier = secrets.token_urlsafe(24), secrets.token_urlsafe(48)
        self.attempts[state] = _Attempt(following, verifier, stamp)
        digest = hashlib.sha256(verifier.encode()).digest()
        return state, base64.urlsafe_b64encode(digest).rstrip(b"=").decode()

    def keep(self, token: str, visitor: Visitor) -> str:
        """Keep who has signed in; return the session's name, for a cookie."""
        if len(self.known) >= MOST:
            self.known.pop(next(iter(self.known)))
        name = secrets.token_urlsafe(24)
        self.known[name] = _Session(token, visitor, self.clock())
        return name


class SignIn:
    """Lets in whom the hub lets in; others are sent there, or refused."""

    def __init__(self, app: ASGIApp, hub: HubClient, sessions: Sessions) -> None:
        self._app = app
        self._hub = hub
        self._sessions = sessions
        self._prefix = hub.environment.prefix

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on with its ``Visitor``, or answer it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        request = HTTPConnection(scope)
        try:
            if quote(scope["path"]) == f"{self._prefix}oauth_callback":
                await (await self._come_back(request))(scope, receive, send)
                return
            visitor = await self._visitor(request)
        except HubError as error:
            await _refuse(503, f"{error}; try again in a moment", scope, receive, send)
            return
        if visitor is None:
            await self._send_away(request, receive, send)
        elif not self._may_enter(visitor):
            words = f"This is not the robot of {visitor.name}: open the link that you were given."
            await _refuse(403, words, scope, receive, send)
        else:
            # The name by which it is called is the hub's: who comes is known otherwise.
            await self._app({**under_own_name(scope), VISITOR: visitor}, receive, send)

    def _may_enter(self, visitor: Visitor) -> bool:
        access = self._hub.environment.access_scopes
        anywhere = {scope.partition("!")[0] for scope in access}
        return bool(visitor.scopes & (access | anywhere))

    async def _visitor(self, request: HTTPConnection) -> Visitor | None:
        kind, _, token = request.headers.get("authorization", "").partition(" ")
        if kind.lower() in ("token", "bearer") and token:
            name = hashlib.sha256(token.encode()).hexdigest()  # a cookie's session has another form
        else:
            name, token = request.cookies.get(SESSION, ""), ""
        session = self._sessions.known.get(name)
        stamp = self._sessions.clock()
        if session is not None and stamp - session.checked < CHECK_S:
            return session.visitor
        token = token or (session.token if session is not None else "")
        if not token:
            return None
        try:
            visitor = await anyio.to_thread.run_sync(self._hub.visitor, token)
        except HubError as error:
            if session is None or error.errno:
                raise
            return session.visitor  # a hub that is begun again is no reason to lose one's robot
        if visitor is None:
            self._sessions.known.pop(name, None)
        else:
            self._sessions.known[name] = _Session(token, visitor, stamp)
        return visitor

    async def _send_away(self, request: HTTPConnection, receive: Receive, send: Send) -> None:
        scope = request.scope
        headers = Headers(scope=scope)
        page = scope.get("method") == "GET" and "text/html" in headers.get("accept", "")
        if not page:
            await _refuse(401, "Sign in first: open your link.", scope, receive, send)
            return
        query = f"?{request.url.query}" if request.url.query else ""
        path = quote(scope["path"])
        # Any other could lead to another site, as //evil.example does.
        following = path + query if path.startswith(self._prefix) else self._prefix
        state, challenge = self._sessions.begin(following)
        asked = urlencode({
            "client_id": self._hub.environment.client_id, "response_type": "code",
            "redirect_uri": self._hub.environment.callback, "state": state,
            "code_challenge": challenge, "code_challenge_method": "S256",
        })  # fmt: skip
        answer = RedirectResponse(f"{self._hub.environment.authorize_url}?{asked}", 302)
        self._set_cookie(answer, request, STATE, state)
        await answer(scope, receive, send)

    async def _come_back(self, request: HTTPConnection) -> Response:
        """Answer a browser that comes back from the hub with a code."""
        state = request.query_params.get("state", "")
        own = request.cookies.get(STATE, "")
        attempt = self._sessions.attempts.pop(state, None)
        # A page of another site could send a code of its own sender along.
        if attempt is None or not hmac.compare_digest(state.encode(), own.encode()):
            return RedirectResponse(self._prefix, 302)
        try:
            code = request.query_params.get("code", "")
            token = await anyio.to_thread.run_sync(self._hub.token_of, code, attempt.verifier)
        except HubError as error:
            if error.errno == 0:
                raise
            return PlainTextResponse("The hub lets you in elsewhere only: open your link.", 403)
        visitor = await anyio.to_thread.run_sync(self._hub.visitor, token)
        if visitor is None:
            return PlainTextResponse("The hub does not know you: open your link.", 403)
        answer = RedirectResponse(attempt.next, 302)
        self._set_cookie(answer, request, SESSION, self._sessions.keep(token, visitor))
        answer.delete_cookie(STATE, path=self._prefix)
        return answer

    def _set_cookie(self, answer: Response, request: HTTPConnection, name: str, value: str) -> None:
        secure = request.headers.get("x-forwarded-proto", request.url.scheme) in ("https", "wss")
        answer.set_cookie(
            name, value, path=self._prefix, httponly=True, samesite="lax", secure=secure
        )


async def _refuse(status: int, words: str, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "http":
        await PlainTextResponse(words, status)(scope, receive, send)
    else:
        await WebSocketClose(code=1008, reason=words[:120])(scope, receive, send)
