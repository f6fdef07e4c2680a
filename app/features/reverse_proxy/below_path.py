"""BelowPath: the application as it is below a path, whether a proxy takes the path away or not."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from urllib.parse import quote

from starlette.responses import RedirectResponse
from starlette.types import ASGIApp, Receive, Scope, Send

from app.feature import NewGate
from app.features.reverse_proxy.own_name import KnownProxy
from app.features.reverse_proxy.settings import ReverseProxySettings
from app.settings.config import Config


def gates(config: Config) -> Iterator[NewGate]:
    """Yield what serves an application below the path that is set, and lets in its proxy."""
    token = os.environ.get("BRICKPOSE_TOKEN")
    if token:
        yield partial(KnownProxy, token=token)
    root = ReverseProxySettings.of(config).root
    if root:
        yield partial(BelowPath, root=root)


class BelowPath:
    """Passes requests on as those of a path below which the application is.

    Some proxies pass a path on as it is (JupyterHub's), others without what is theirs
    (jupyter-server-proxy, ``proxy_pass`` of nginx with a path). No address of ours begins as the
    path does, so both are told apart by the request. Who comes without the proxy is served, too.
    """

    def __init__(self, app: ASGIApp, root: str) -> None:
        """Serve an application below ``root``, a decoded path without a slash at its end."""
        self._app = app
        self._root = root

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass a request on; the path without its last slash leads to that with it."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        path = scope["path"]
        if path == self._root and scope["type"] == "http":
            # Relative: the proxy may be known by another name, and another scheme.
            query = scope["query_string"].decode("ascii", "replace")
            place = quote(self._root.rpartition("/")[2]) + "/" + (f"?{query}" if query else "")
            await RedirectResponse(f"./{place}")(scope, receive, send)
            return
        if not path.startswith(self._root + "/"):
            path = self._root + path
        below = {**scope, "root_path": self._root, "path": path}
        await self._app(below, receive, send)
