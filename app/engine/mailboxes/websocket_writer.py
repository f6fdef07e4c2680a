"""Sends the messages of several tasks on one websocket, until the other end is gone."""

from __future__ import annotations

import anyio
from starlette.websockets import WebSocket, WebSocketDisconnect


class WebsocketWriter:
    """Sends one message after the other."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket
        self._sending = anyio.Lock()

    async def send(self, data: str | bytes) -> bool:
        """Send one message; return False if the other end is gone."""
        try:
            async with self._sending:
                if isinstance(data, str):
                    await self._socket.send_text(data)
                else:
                    await self._socket.send_bytes(data)
        except (WebSocketDisconnect, RuntimeError):
            # Starlette raises a RuntimeError if something is sent after the close.
            return False
        return True
