"""Lets one client talk to its session, over a websocket."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeVar

import anyio
from anyio.abc import TaskGroup
from starlette import status
from starlette.websockets import WebSocket

from app.engine.mailboxes.slow_lane import SlowLane
from app.engine.mailboxes.wakeup import Wakeup
from app.engine.mailboxes.websocket_writer import WebsocketWriter

Data = str | bytes
Later = Callable[[], Data]
"""An answer that takes time; a thread calls it."""

Shared = TypeVar("Shared")

MOST_CLIENTS = 50
"""Most clients of one protocol at the same time: each costs a little in every tick."""


class Session(Protocol):
    """One client, without its socket; used by the event loop."""

    def receive(self, data: Data) -> Sequence[Data | Later]:
        """Carry out a message; return the answers to send. An invalid message raises nothing."""
        ...

    def next(self) -> Data | None:
        """The next message for the client; None if nothing waits."""
        ...

    def close(self) -> None:
        """End all that the client has asked for."""
        ...


class Clients(Generic[Shared]):
    """Counts the clients of one protocol, and has what they share."""

    def __init__(self, make_shared: Callable[[], Shared]) -> None:
        self._make_shared = make_shared
        self._shared: Shared | None = None
        self._count = 0

    async def shared(self) -> Shared:
        """Return what all clients share, made for the first one.

        Reading the types takes 0.2 s, so it runs in another thread and delays nobody else.
        """
        if self._shared is None:
            made = await anyio.to_thread.run_sync(self._make_shared)
            if self._shared is None:
                self._shared = made
        return self._shared

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
        self._slow_lane = SlowLane()
        self._waiting = Wakeup()
        self._outgoing = WebsocketWriter(socket)
        self._session = begin(self._waiting)

    async def run(self, greetings: Sequence[Data]) -> None:
        try:
            async with anyio.create_task_group() as tasks:
                for greeting in greetings:
                    await self._outgoing.send(greeting)
                tasks.start_soon(self._send_messages)
                await self._take_requests(tasks)
                tasks.cancel_scope.cancel()
        finally:
            self._session.close()

    async def _send_messages(self) -> None:
        while True:
            await self._waiting.wait()
            while (data := self._session.next()) is not None:
                if not await self._outgoing.send(data):
                    return

    async def _take_requests(self, tasks: TaskGroup) -> None:
        """Answer each message, until the client is gone."""
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            data = message.get("text") or message.get("bytes") or ""
            for answer in self._session.receive(data):
                if callable(answer):
                    await self._slow_lane.begin(tasks, answer, self._outgoing.send)
                    continue
                # While a client does not read its answers, its messages are not read either.
                if not await self._outgoing.send(answer):
                    return
