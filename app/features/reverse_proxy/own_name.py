"""Requests whose sender is known need no check of the name by which they call this server.

A page of another site can point a name of its own at this computer: that is why the page's server
knows its names. It cannot bring what a proxy brings, who has a token or has asked a hub. So with
that, the name is the proxy's, which may be any.
"""

from __future__ import annotations

import hmac
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.types import ASGIApp, Receive, Scope, Send

OWN = "localhost"


class KnownProxy:
    """Lets a proxy that brings the token call this server by any name."""

    def __init__(self, app: ASGIApp, token: str) -> None:
        self._app = app
        self._bearer = f"Bearer {token}".encode()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on; browsers send such a header only if a page tells them the token."""
        if scope["type"] in ("http", "websocket"):
            brought = Headers(scope=scope).get("authorization", "").encode("latin-1")
            if hmac.compare_digest(brought, self._bearer):
                scope = under_own_name(scope)
        await self._app(scope, receive, send)


def under_own_name(scope: Scope) -> Scope:
    """Return a request as if it called this server by its own name.

    Its origin is then that name's, if it was the proxy's; pages of other sites stay such.
    """
    own = dict(scope, headers=list(scope["headers"]))
    headers = MutableHeaders(scope=own)
    host, origin = headers.get("host", ""), headers.get("origin")
    if origin is not None and _place(origin) == host.lower():
        headers["origin"] = f"http://{OWN}"
    headers["host"] = OWN
    return own


def _place(origin: str) -> str:
    try:
        return urlsplit(origin).netloc.lower()
    except ValueError:
        return ""
