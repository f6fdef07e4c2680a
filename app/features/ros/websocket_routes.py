"""``/rosbridge`` and ``/foxglove``: a websocket for each client or viewer."""

from __future__ import annotations

from functools import partial

from fastapi import APIRouter
from starlette import status
from starlette.websockets import WebSocket

from app.engine.driver import Driver
from app.features.ros.foxglove.offer import Offer
from app.features.ros.foxglove.protocol import SUBPROTOCOLS
from app.features.ros.foxglove.session import FoxgloveSession
from app.features.ros.guests import FOXGLOVE
from app.features.ros.inbox import Inbox
from app.features.ros.publisher import TopicPublisher
from app.features.ros.rosbridge.bridge import Bridge
from app.features.ros.rosbridge.session import RosbridgeSession
from app.features.ros.websocket_session import Clients
from app.page.token_guard import role_in
from app.page.tokens import Role
from app.settings.groups import Ros2Settings


class Rosbridge:
    """All clients of one program."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox) -> None:
        self._clients = Clients(partial(Bridge, publisher, inbox))

    async def serve(self, socket: WebSocket, *, watches: bool = False) -> None:
        """Talk to one client until it leaves; whether it only watches."""
        bridge = await self._clients.shared()
        driver = Driver.numbered("rosbridge {number}", socket.client and socket.client.host)
        await self._clients.talk(
            socket, lambda waiting: RosbridgeSession(bridge, waiting.set, driver, watches=watches)
        )


WATCHES = "this token only watches; ask for the link to drive"
SWITCHED_OFF = "Foxglove only watches; foxglove_commands = true in [ros2] lets it drive"


class Foxglove:
    """All viewers of one program."""

    def __init__(self, publisher: TopicPublisher, inbox: Inbox, settings: Ros2Settings) -> None:
        self._settings = settings
        self._clients = Clients(partial(Offer, publisher, inbox))

    async def serve(self, socket: WebSocket, *, watches: bool = False) -> None:
        """Talk to one viewer until it leaves; whether its token only watches."""
        offered = socket.scope.get("subprotocols", [])
        protocol = next((name for name in offered if name in SUBPROTOCOLS), None)
        if protocol is None:
            await socket.accept()
            await socket.close(
                status.WS_1002_PROTOCOL_ERROR, f"valid subprotocols: {', '.join(SUBPROTOCOLS)}"
            )
            return
        offer = await self._clients.shared()
        driver = Driver.numbered("Foxglove {number}", socket.client and socket.client.host)
        refusal = WATCHES if watches else SWITCHED_OFF
        allowed = self._settings.foxglove_commands and not watches
        await self._clients.talk(
            socket,
            lambda waiting: FoxgloveSession(
                offer, waiting.set, driver, None if allowed else refusal
            ),
            subprotocol=protocol,
            greetings=offer.greetings(commands=allowed),
        )


def topics_router(rosbridge: Rosbridge, foxglove: Foxglove | None) -> APIRouter:
    """Return the addresses of clients and, if there may be any, of viewers."""
    router = APIRouter()

    # roslibpy's Ros(host, port) takes no path.
    @router.websocket("/")
    @router.websocket("/rosbridge")
    async def follow_topics(socket: WebSocket) -> None:
        await rosbridge.serve(socket, watches=role_in(socket.scope) is Role.WATCH)

    if foxglove is not None:

        @router.websocket(FOXGLOVE.path)
        async def follow_viewer(socket: WebSocket) -> None:
            await foxglove.serve(socket, watches=role_in(socket.scope) is Role.WATCH)

    return router
