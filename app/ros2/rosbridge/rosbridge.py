"""``/rosbridge``: a websocket for each client."""

from __future__ import annotations

import anyio
from starlette.websockets import WebSocket

from app.engine.drivers import Driver
from app.engine.mailboxes.wakeup import Wakeup
from app.engine.mailboxes.websocket_writer import WebsocketWriter
from app.ros2.inbox import Inbox
from app.ros2.publisher import TopicPublisher
from app.ros2.rosbridge.bridge import Bridge
from app.ros2.rosbridge.session import Session

MOST_CLIENTS = 50
"""Most clients at the same time: each costs a little in every tick."""

TRY_AGAIN_LATER = 1013


class Rosbridge:
    """All clients of one program."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox) -> None:
        self._publisher, self._inbox = publisher, inbox
        self._bridge: Bridge | None = None
        self._clients = 0

    async def serve(self, socket: WebSocket, *, watches: bool = False) -> None:
        """Talk to one client until it leaves; whether it only watches."""
        if self._clients >= MOST_CLIENTS:
            await socket.close(TRY_AGAIN_LATER, f"{MOST_CLIENTS} clients are connected already")
            return
        self._clients += 1
        try:
            await socket.accept()
            await _Client(socket, await self._shared(), watches).talk()
        finally:
            self._clients -= 1

    async def _shared(self) -> Bridge:
        """Return the bridge, made for the first client.

        Reading the types takes 0.2 s, so it runs in another thread and delays nobody else.
        """
        if self._bridge is None:
            made = await anyio.to_thread.run_sync(Bridge, self._publisher, self._inbox)
            self._bridge = self._bridge or made
        return self._bridge


class _Client:
    def __init__(self, socket: WebSocket, bridge: Bridge, watches: bool) -> None:
        self._socket = socket
        self._waiting = Wakeup()
        self._outgoing = WebsocketWriter(socket)
        self._session = Session(
            bridge,
            self._waiting.set,
            Driver.numbered("rosbridge", socket.client and socket.client.host),
            watches=watches,
        )

    async def talk(self) -> None:
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._send_messages)
                await self._take_requests()
                tasks.cancel_scope.cancel()
        finally:
            self._session.close()

    async def _send_messages(self) -> None:
        while True:
            await self._waiting.wait()
            while (data := self._session.next()) is not None:
                if not await self._outgoing.send(data):
                    return

    async def _take_requests(self) -> None:
        """Answer each message, until the client is gone."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            data = message.get("text") or message.get("bytes") or ""
            for answer in self._session.receive(data):
                # While a client does not read its answers, its messages are not read either.
                if not await self._outgoing.send(answer):
                    return
