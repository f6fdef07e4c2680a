"""The hub's proxy: configurable-http-proxy in Python, with sockets that end and never fill up.

As published (0.4.0) it leaves a page's socket open when the server behind it ends, so the page
waits for ever; takes all that a server sends, however slowly the page reads, so pictures pile up
here and come later and later; and gives stamps of the last use in local time without saying so,
which a hub reads as UTC: west of Greenwich it ended robots in use.
"""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from typing import Any
from urllib.parse import urlsplit

from configurable_http_proxy import cli, configproxy
from configurable_http_proxy.handlers import ProxyHandler, apply_timeout
from tornado.httpclient import HTTPClientError
from tornado.iostream import StreamClosedError
from tornado.websocket import WebSocketClosedError, websocket_connect

LONGEST_ANSWER_S = 3600.0
"""A server may take so long for an answer [s], as node's proxy lets it; tornado's own 20 s end
uploads of recordings that a busy computer reads."""


class SteadyHandler(ProxyHandler):
    """Passes on one message of a socket after the other, and its end."""

    async def start_ws_client(self, path: str | None = None) -> None:
        """Connect to the server that a page's socket is for."""
        self.closed = False
        url = await self.get_target_url(path)
        if url is None:
            return
        place = urlsplit(url)
        place = place._replace(scheme=place.scheme.replace("http", "ws"))
        request = self._get_proxy_request(place.geturl())
        try:
            # Without a callback tornado reads a message only when the one before was taken.
            connecting = websocket_connect(request)
            self.ws_client = await apply_timeout(self.proxy.timeout, connecting)
        except HTTPClientError as error:
            self.set_status(error.code)
            self.write(error.message or "")
            self.finish()
        except Exception as error:
            await self.handle_proxy_error(503, error)
            raise

    def open(self, *_: str, **__: str) -> None:
        """Begin to pass on what the server sends."""
        self._passing = asyncio.ensure_future(self._pass_on())

    async def _pass_on(self) -> None:
        server = self.ws_client
        while (message := await server.read_message()) is not None:
            self._note_use()
            try:
                # It waits until the page has room again: until then the server sends newer ones.
                await self.write_message(message, binary=isinstance(message, bytes))
            except (WebSocketClosedError, StreamClosedError):
                return
        self.close(server.close_code, server.close_reason)

    async def on_message(self, message: str | bytes) -> None:
        """Pass on what a page sends."""
        if self.ws_client is not None:
            self._note_use()
            try:
                await self.ws_client.write_message(message, binary=isinstance(message, bytes))
            except (WebSocketClosedError, StreamClosedError):
                self.close()

    def _note_use(self) -> None:
        prefix = self.target["prefix"] if self.target else ""
        if prefix:
            self.proxy.update_last_activity(prefix)


class PatientProxy(configproxy.PythonProxy):
    """Waits for long answers, and says in which time zone its stamps are."""

    def __init__(self, options: Any = ()) -> None:
        super().__init__({**dict(options), "proxy_timeout": LONGEST_ANSWER_S})

    def update_last_activity(self, prefix: str) -> Any:
        """Note that something is used now."""
        if self._routes.get(prefix):
            self._routes.update(prefix, {"last_activity": datetime.now(UTC)})


def main() -> None:
    """Serve, by the options of ``configurable-http-proxy``."""
    configproxy.ProxyHandler = SteadyHandler
    cli.PythonProxy = PatientProxy
    cli.main()


if __name__ == "__main__":
    main()
