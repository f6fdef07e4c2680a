"""``/rosbridge``: a websocket for each client."""

from __future__ import annotations

import anyio
from starlette.websockets import WebSocket

from app.engine.drivers import Driver
from app.ros2.inbox import Inbox
from app.ros2.publisher import TopicPublisher
from app.ros2.rosbridge.bridge import Bridge
from app.ros2.rosbridge.session import Session
from app.ros2.websocket_session import Clients


class Rosbridge:
    """All clients of one program."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox) -> None:
        self._publisher, self._inbox = publisher, inbox
        self._bridge: Bridge | None = None
        self._clients = Clients()

    async def serve(self, socket: WebSocket, *, watches: bool = False) -> None:
        """Talk to one client until it leaves; whether it only watches."""
        bridge = await self._shared()
        driver = Driver.numbered("rosbridge", socket.client and socket.client.host)
        await self._clients.talk(
            socket, lambda waiting: Session(bridge, waiting.set, driver, watches=watches)
        )

    async def _shared(self) -> Bridge:
        """Return the bridge, made for the first client.

        Reading the types takes 0.2 s, so it runs in another thread and delays nobody else.
        """
        if self._bridge is None:
            made = await anyio.to_thread.run_sync(Bridge, self._publisher, self._inbox)
            self._bridge = self._bridge or made
        return self._bridge
