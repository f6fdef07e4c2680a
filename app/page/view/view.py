"""viser on our own port: its page at ``/view/``, its websocket forwarded at ``/view``."""

from __future__ import annotations

import contextlib
import hashlib
import io
import socket
from pathlib import Path
from typing import Any

import anyio
import anyio.to_thread
import viser
import viser._messages
import websockets
from starlette.requests import Request
from starlette.responses import Response
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.asyncio.client import connect

from app.engine.mailboxes.latest import Latest
from app.engine.problems import LOG
from app.engine.snapshot import Snapshot
from app.page.view.scene import Scene
from robot.description.spec import RobotSpec
from robot.fields.field import Field

UPDATES_HZ = 15
SMALL_BUFFER = 16 * 1024
"""Size of socket buffers [bytes]: data in larger ones is old when a slow viewer gets it."""

PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
"""viser's whole client is this one file."""

INJECTED_HTML = b"""<style>[data-floating-window]{display:none!important}</style>
<script>document.hasFocus = () => true;</script>"""
"""Added to viser's page. Our page has the controls, so viser's panel is hidden. viser's client
reconnects only while it has the focus, which a frame in a page often lacks."""


class View:
    """A viser server behind our port: only viewers who may see the page can reach it."""

    def __init__(self, field: Field, spec: RobotSpec, latest: Latest[Snapshot]) -> None:
        with contextlib.redirect_stdout(io.StringIO()):  # viser prints its own address
            self._server = viser.ViserServer(host="127.0.0.1", port=18080, verbose=False)
        infra = self._server._websock_server
        # viser's share button would make this server call one on the internet.
        infra.unregister_handler(viser._messages.ShareUrlRequest)
        infra.on_client_connect(self._shrink_buffer)
        self._scene = Scene(self._server, field, spec)
        self._latest = latest
        self.failure: str | None = None
        """Why the view stopped, if it failed."""
        self._page = _page()
        self._tag = f'"{hashlib.sha256(self._page).hexdigest()[:16]}"'

    def page(self, request: Request) -> Response:
        """Return viser's page, or status 304 to a browser that has it."""
        headers = {"ETag": self._tag, "Cache-Control": "no-cache"}
        if request.headers.get("if-none-match") == self._tag:
            return Response(status_code=304, headers=headers)
        return Response(self._page, media_type="text/html", headers=headers)

    async def follow(self) -> None:
        """Keep the scene up to date, until cancelled; a failure ends only the 3D view."""
        try:
            with self._latest.subscribe() as subscription:
                while True:
                    snapshot = await subscription.next()
                    await anyio.to_thread.run_sync(self._scene.update, snapshot)
                    await anyio.sleep(1 / UPDATES_HZ)
        except Exception as error:
            LOG.exception("the 3D view stopped")
            self.failure = f"The 3D view stopped: {error}"

    async def serve(self, socket: WebSocket) -> None:
        """Forward one viewer's messages in both directions, until one side ends."""
        offered = socket.scope.get("subprotocols", [])
        try:
            upstream = await connect(
                f"ws://127.0.0.1:{self._server.get_port()}",
                subprotocols=[websockets.Subprotocol(name) for name in offered] or None,
                compression=None,
                max_size=None,
                max_queue=2,
                proxy=None,
                sock=_small_socket(self._server.get_port()),
            )
        except (OSError, websockets.InvalidHandshake):
            await socket.close(code=1013, reason="the 3D view is not there")
            return
        try:
            async with anyio.create_task_group() as tasks:
                await socket.accept(subprotocol=upstream.subprotocol)
                tasks.start_soon(_pass_down, upstream, socket, tasks.cancel_scope)
                tasks.start_soon(_pass_up, socket, upstream, tasks.cancel_scope)
        finally:
            # A clean close would wait for viser, but the end of the program must not wait.
            upstream.transport.abort()

    def close(self) -> None:
        """End viser's threads."""
        with contextlib.redirect_stdout(io.StringIO()):
            self._server.stop()

    def _shrink_buffer(self, connection: Any) -> None:
        live = self._server._websock_server._live_connections[connection.client_id]
        raw = live.transport.get_extra_info("socket")
        raw.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, SMALL_BUFFER)


async def _pass_down(upstream: Any, socket: WebSocket, scope: anyio.CancelScope) -> None:
    try:
        async for message in upstream:
            if isinstance(message, bytes):
                await socket.send_bytes(message)
            else:
                await socket.send_text(message)
    except (WebSocketDisconnect, RuntimeError, websockets.ConnectionClosed):
        pass  # one side is gone: both end
    scope.cancel()


async def _pass_up(socket: WebSocket, upstream: Any, scope: anyio.CancelScope) -> None:
    try:
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                break
            content = message.get("bytes")
            await upstream.send(content if content is not None else message["text"])
    except websockets.ConnectionClosed:
        pass  # viser is gone: both end
    scope.cancel()


def _page() -> bytes:
    page = PAGE.read_bytes()
    head = page.index(b"<head>") + len(b"<head>")
    return page[:head] + INJECTED_HTML + page[head:]


def _small_socket(port: int) -> socket.socket:
    small = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    small.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL_BUFFER)
    small.connect(("127.0.0.1", port))
    small.setblocking(False)
    return small
