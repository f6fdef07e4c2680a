"""Hands our websockets over to viser's server, which then needs no port of its own.

A port on loopback, too, can be reached by every page that a browser on this computer shows, and
viser's server asks nobody who they are. So the websocket library's server, which viser starts in a
thread of its own, is replaced by one that listens nowhere: our server checks who comes.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from contextlib import contextmanager, suppress
from types import SimpleNamespace
from typing import Any, TypeVar

import viser
import websockets.asyncio.server
from starlette import status
from starlette.websockets import WebSocket, WebSocketDisconnect
from websockets.exceptions import ConnectionClosedOK

from app.engine.problems import CLIENTS_LOG
from app.page.view.cameras import PAGE

PROTOCOL = f"viser-v{viser.__version__}"
"""The subprotocol of viser's client; another version's cannot read the messages."""

T = TypeVar("T")


class Viewers:
    """All viewers of one viser server; stands where the websocket library's server would."""

    def __init__(self) -> None:
        self.server = SimpleNamespace(sockets=())
        """viser looks here for the port that it has."""
        self._handler: Callable[[Any], Awaitable[None]] | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._tasks: set[asyncio.Task[Any]] = set()

    def __call__(self, handler: Callable[[Any], Awaitable[None]], *_: Any, **__: Any) -> Viewers:
        """Keep viser's handler of connections; address and options are of no use here."""
        self._handler = handler
        return self

    async def __aenter__(self) -> Viewers:
        self._loop = asyncio.get_running_loop()
        return self

    async def __aexit__(self, *_: object) -> None:
        self._loop = None
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)

    @property
    def present(self) -> bool:
        """Whether anybody looks."""
        return bool(self._tasks)

    async def serve(self, socket: WebSocket) -> None:
        """Serve one viewer in viser's event loop, until one side ends."""
        loop = self._loop
        if loop is None:
            await socket.close(status.WS_1013_TRY_AGAIN_LATER, "the 3D view is not there")
            return
        if PROTOCOL not in socket.scope.get("subprotocols", []):
            await socket.accept()
            await socket.close(
                status.WS_1002_PROTOCOL_ERROR, f"the 3D view speaks {PROTOCOL}: reload the page"
            )
            return
        await socket.accept(subprotocol=PROTOCOL)
        page = socket.path_params.get("page", "")
        viewer = _Viewer(socket, asyncio.get_running_loop())
        work = asyncio.run_coroutine_threadsafe(self._handle(viewer, page), loop)
        await asyncio.wrap_future(work)

    async def _handle(self, viewer: _Viewer, page: str) -> None:
        PAGE.set(page)
        assert self._handler is not None
        task = asyncio.current_task()
        assert task is not None
        self._tasks.add(task)
        try:
            await self._handler(viewer)
        except asyncio.CancelledError:
            pass  # the view ends, or our websocket has: so does this task
        except Exception as error:  # viser expects well-formed messages; the others go on
            CLIENTS_LOG.warning("a viewer of the 3D view sent what viser cannot read: %r", error)
            await viewer.close(status.WS_1003_UNSUPPORTED_DATA, "this is no message of viser's")
        finally:
            self._tasks.discard(task)


class _Viewer:
    """A websocket of our event loop, as viser's loop uses it: the library's interface."""

    def __init__(self, socket: WebSocket, loop: asyncio.AbstractEventLoop) -> None:
        self.subprotocol = PROTOCOL
        self._socket = socket
        self._loop = loop

    async def send(self, data: bytes) -> None:
        """Send a message; waits while the viewer is slow."""
        try:
            await self._ask(self._socket.send_bytes(data))
        except (WebSocketDisconnect, RuntimeError):
            raise ConnectionClosedOK(None, None) from None

    async def recv(self) -> bytes:
        """Return the next message."""
        message = await self._ask(self._socket.receive())
        if message["type"] == "websocket.disconnect":
            raise ConnectionClosedOK(None, None)
        data = message.get("bytes")
        if data is None:
            raise ValueError("a text")
        return bytes(data)

    async def close(self, code: int, reason: str) -> None:
        """Close the websocket, unless it is closed."""
        with suppress(WebSocketDisconnect, RuntimeError):
            await self._ask(self._socket.close(code, reason))

    async def _ask(self, work: Coroutine[Any, Any, T]) -> T:
        return await asyncio.wrap_future(asyncio.run_coroutine_threadsafe(work, self._loop))


@contextmanager
def without_port(viewers: Viewers) -> Iterator[None]:
    """Let viser's server that is made here have these viewers instead of a port.

    viser offers no way to give it connections, and looks the server up when it starts.
    """
    module = websockets.asyncio.server
    listening = module.serve
    module.serve = viewers  # type: ignore[assignment, misc]
    try:
        yield
    finally:
        module.serve = listening  # type: ignore[misc]
