"""Lets one client talk to its session, over a websocket."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

import anyio
from starlette import status
from starlette.websockets import WebSocket

from app.engine.mailboxes.wakeup import Wakeup
from app.engine.mailboxes.websocket_writer import WebsocketWriter

Data = str | bytes

MOST_CLIENTS = 50
"""Most clients of one protocol at the same time: each costs a little in every tick."""


class Session(Protocol):
    """One client, without its socket; used by the event loop."""

    def receive(self, data: Data) -> Sequence[Data]:
        """Carry out a message; return the answers to send. An invalid message raises nothing."""
        ...

    def next(self) -> Data | None:
        """The next message for the client; None if nothing waits."""
        ...

    def close(self) -> None:
        """End all that the client has asked for."""
        ...


class Clients:
    """Counts the clients of one protocol."""

    def __init__(self) -> None:
        self._count = 0

    async def talk(
        self,
        socket: WebSocket,
        begin: Callable[[Wakeup], Session],
        *,
        subprotocol: str | None = None,
        greetings: Sequence[Data] = (),
    ) -> None:
        """Talk to one client until it leaves.

        Args:
            socket: the client's websocket, not accepted yet.
            begin: makes its session; the wake-up is set when ``next`` has a message.
            subprotocol: the subprotocol to accept.
            greetings: the first messages.
        """
        if self._count >= MOST_CLIENTS:
            await socket.close(
                status.WS_1013_TRY_AGAIN_LATER, f"{MOST_CLIENTS} clients are connected already"
            )
            return
        self._count += 1
        try:
            await socket.accept(subprotocol)
            await _Talk(socket, begin).run(greetings)
        finally:
            self._count -= 1


class _Talk:
    def __init__(self, socket: WebSocket, begin: Callable[[Wakeup], Session]) -> None:
        self._socket = socket
        self._waiting = Wakeup()
        self._outgoing = WebsocketWriter(socket)
        self._session = begin(self._waiting)

    async def run(self, greetings: Sequence[Data]) -> None:
        try:
            async with anyio.create_task_group() as tasks:
                for greeting in greetings:
                    await self._outgoing.send(greeting)
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
