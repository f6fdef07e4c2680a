"""Access control: only pages of this server, under its own address, may talk to the robot.

A setting can let in pages of other origins.

Some paths invite pages of other origins that bring a token in the address, because programs that
run in a browser, as Foxglove, come from a place of their own.

Without this check, a page of another site could send commands from the user's own browser; its
Origin header shows that. Or it could point its own host name at this machine and so be of the same
origin; its Host header shows that. Or it could show our page in a frame and let the user's clicks
and keys fall into it; a header on every answer forbids that to browsers.
"""

from __future__ import annotations

import ipaddress
import socket
from urllib.parse import urlsplit

from starlette._utils import get_route_path
from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import HTTPConnection
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketClose

GUARDS = {
    "Content-Security-Policy": "frame-ancestors 'self'",
    "X-Frame-Options": "SAMEORIGIN",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "same-origin",
}
"""Headers of every answer: no other site may frame it or learn its address, which may hold a token,
and no browser guesses its type."""


GUEST = "brickpose.guest"


def is_guest(scope: Scope) -> bool:
    """Whether a page of another origin sent this, which may come in by its token alone."""
    return bool(scope.get(GUEST, False))


class SameOriginOnly:
    """Refuses requests and sockets whose Host or Origin is not this server's."""

    def __init__(
        self,
        app: ASGIApp,
        names: frozenset[str],
        origins: tuple[str, ...] = (),
        inviting: frozenset[str] = frozenset(),
    ) -> None:
        """Guard an application.

        Args:
            app: the application to guard.
            names: host names of this server.
            origins: other origins to let in, such as ``http://localhost:5500``; files have the
                origin ``null``.
            inviting: paths that invite pages of other origins with a token, which the application
                has to check: ``is_guest`` tells them.
        """
        self._app = app
        self._names = names
        self._origins = frozenset(origin.rstrip("/").lower() for origin in origins)
        self._inviting = inviting

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on, or refuse it."""

        async def send_guarded(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(GUARDS)
            await send(message)

        if scope["type"] in ("http", "websocket"):
            complaint = self._complaint(Headers(scope=scope))
            scope[GUEST] = complaint is not None and self._invites(scope)
            if complaint is not None and not scope[GUEST]:
                await _refuse(complaint, scope, receive, send_guarded)
                return
        await self._app(scope, receive, send_guarded)

    def _complaint(self, headers: Headers) -> str | None:
        host = headers.get("host", "")
        if not self._is_own_host(host):
            return f"This server does not go by the name {host!r}; open it by its address."
        origin = headers.get("origin")
        if origin is not None and origin.lower() in self._origins:
            return None
        if origin is not None and _place(origin) != host.lower():
            return f"Pages of {origin} may not talk to this robot."
        site = headers.get("sec-fetch-site", "none")
        # A link on another site may be followed; in a frame, any page could follow it unseen.
        followed = (headers.get("sec-fetch-mode"), headers.get("sec-fetch-dest", "document"))
        if site not in ("same-origin", "none") and followed != ("navigate", "document"):
            return "Pages of other sites may not show this robot's pages and pictures."
        return None

    def _invites(self, scope: Scope) -> bool:
        """Whether a foreign page may come in, if its token is right; a foreign host never."""
        request = HTTPConnection(scope)
        return (
            get_route_path(scope) in self._inviting
            and "token" in request.query_params
            and self._is_own_host(request.headers.get("host", ""))
        )

    def _is_own_host(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:  # brackets without an IPv6 address
            return False
        # Another site can point a host name at this machine, but it cannot choose an IP address.
        return name.lower() in self._names or _is_address(name)


def own_names(host: str) -> frozenset[str]:
    """Return the names of this machine, and the configured host."""
    machine = socket.gethostname().lower()
    return frozenset({"localhost", host.lower(), machine, f"{machine}.local"})


def _place(origin: str) -> str:
    """Return host and port of an origin; empty if it is not valid."""
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return ""


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


async def _refuse(complaint: str, scope: Scope, receive: Receive, send: Send) -> None:
    if scope["type"] == "http":
        await PlainTextResponse(complaint, status_code=403)(scope, receive, send)
    else:
        await WebSocketClose(code=1008, reason=complaint[:120])(scope, receive, send)
