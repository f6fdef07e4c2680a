"""Who may talk to the robot: pages of this server, by an address that is really this one.

Pages of other places are let in by a setting only, each by its origin.

A page of another site could otherwise send commands from the user's own browser (its Origin tells),
or point a name of its own at this machine and be of the same origin (its Host tells).
"""

from __future__ import annotations

import ipaddress
import socket
from urllib.parse import urlsplit

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocketClose


class SameOriginOnly:
    """Refuses requests and sockets whose Host or Origin is not this server's."""

    def __init__(self, app: ASGIApp, names: frozenset[str], origins: tuple[str, ...] = ()) -> None:
        """Args:

        app: what is guarded.
        names: of this server.
        origins: of other places, as ``http://localhost:5500``; ``null`` is that of files.
        """
        self._app = app
        self._names = names
        self._origins = frozenset(origin.rstrip("/").lower() for origin in origins)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass on, or refuse."""
        if scope["type"] in ("http", "websocket"):
            complaint = self._complaint(Headers(scope=scope))
            if complaint is not None:
                await _refuse(complaint, scope, receive, send)
                return
        await self._app(scope, receive, send)

    def _complaint(self, headers: Headers) -> str | None:
        host = headers.get("host", "")
        if not self._is_ours(host):
            return f"This server does not go by the name {host!r}; open it by its address."
        origin = headers.get("origin")
        if origin is not None and origin.lower() in self._origins:
            return None
        if origin is not None and _place(origin) != host.lower():
            return f"Pages of {origin} may not talk to this robot."
        site = headers.get("sec-fetch-site", "none")
        if site not in ("same-origin", "none") and headers.get("sec-fetch-mode") != "navigate":
            return "Pages of other sites may not show this robot's pictures."
        return None

    def _is_ours(self, host: str) -> bool:
        try:
            name = urlsplit(f"//{host}").hostname or ""
        except ValueError:  # brackets that are no IPv6 address
            return False
        # A page cannot choose which number stands in its address, only which name.
        return name.lower() in self._names or _is_address(name)


def own_names(host: str) -> frozenset[str]:
    """The names of this machine, and the one that it was told to listen on."""
    machine = socket.gethostname().lower()
    return frozenset({"localhost", host.lower(), machine, f"{machine}.local"})


def _place(origin: str) -> str:
    """Host and port of an origin; empty if it is none."""
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
