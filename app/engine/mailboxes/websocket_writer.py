"""What goes out on a websocket that several tasks write to, until its other end is gone."""

from __future__ import annotations

import anyio
from starlette.websockets import WebSocket, WebSocketDisconnect


class WebsocketWriter:
    """One message after the other."""

    def __init__(self, socket: WebSocket) -> None:
        self._socket = socket
        self._sending = anyio.Lock()

    async def send(self, data: str | bytes) -> bool:
        """Send one message; False if nobody is there any more."""
        try:
            async with self._sending:
                if isinstance(data, str):
                    await self._socket.send_text(data)
                else:
                    await self._socket.send_bytes(data)
        except (WebSocketDisconnect, RuntimeError):
            # Starlette raises a RuntimeError for what is sent after the close.
            return False
        return True
