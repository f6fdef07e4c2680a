"""``/rosbridge``: a websocket for each client."""

from __future__ import annotations

from functools import partial

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
        self._clients = Clients(partial(Bridge, publisher, inbox))

    async def serve(self, socket: WebSocket, *, watches: bool = False) -> None:
        """Talk to one client until it leaves; whether it only watches."""
        bridge = await self._clients.shared()
        driver = Driver.numbered("rosbridge", socket.client and socket.client.host)
        await self._clients.talk(
            socket, lambda waiting: Session(bridge, waiting.set, driver, watches=watches)
        )
